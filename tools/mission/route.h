// Collects what the items of a file say into the waypoints and jumps of a Mission.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/mission/mission.h"

namespace landfix::mission {

/// Numbers of MAVLink's commands (MAV_CMD) that are read or written by name here.
enum Command : int {
  kWaypointCommand = 16,
  kLoiterCommand = 17,
  kLoiterTurnsCommand = 18,
  kLoiterTimeCommand = 19,
  kReturnCommand = 20,
  kLandCommand = 21,
  kTakeoffCommand = 22,
  kLoiterToAltitudeCommand = 31,
  kSplineCommand = 82,
  kVtolTakeoffCommand = 84,
  kVtolLandCommand = 85,
  kDelayCommand = 93,
  kPayloadPlaceCommand = 94,
  kLastNavCommand = 95,
  kJumpCommand = 177,
  kChangeSpeedCommand = 178,
  kJumpTagCommand = 600,
  kJumpToTagCommand = 601,
};

/// Numbers of MAVLink's frames (MAV_FRAME) that are written.
enum Frame : int { kGlobalFrame = 0, kMissionFrame = 2, kHomeFrame = 3, kTerrainFrame = 10 };

/// One MAVLink mission item as files hold it.
struct MissionItem {
  int command = 0;
  int frame = 0;
  std::array<double, 7> params{};  ///< NaN where the file has none; [4..6]: latitude, longitude (degrees), altitude (m)
  std::optional<Altitude> altitude;  ///< taken where params[6] is NaN
  size_t item = 0, part = 0;
  std::string where;  ///< for messages: "mission.items[3]", "line 5"
};

/// Throws Error (kBadInput) unless both are degrees on Earth and not 0, 0 (what programs write for "nowhere").
Position checked_position(const std::string& file, const std::string& where, double latitude_deg, double longitude_deg);

class Route {
 public:
  explicit Route(Mission& mission) : mission_(mission) {}

  /// Says that what comes next is the target of jumps to this id; the first to name an id has it.
  void mark(long id);

  /// Interprets a command. Throws Error (kBadInput) as read.h says.
  void add(const MissionItem& item);

  /// Adds a point of a bare line.
  void add(const Place& place, size_t item, size_t part);

  /// Resolves the jumps. Throws Error (kBadInput) where a target does not exist, or jumps lead in a circle without a
  /// waypoint in it.
  void finish();

 private:
  struct Mark {
    size_t waypoints = 0, jumps = 0;
  };
  struct Pending {
    long target = 0;
    bool tag = false;
    std::string where;
  };

  void append(Waypoint waypoint, const std::string& where);
  void add_flown(const MissionItem& item, Action action);
  void add_jump(const MissionItem& item);
  void add_speed(const MissionItem& item);
  bool imply_position(Waypoint& waypoint);
  void refuse_circles() const;
  [[noreturn]] void refuse(const std::string& where, const std::string& expected_found_advice) const;

  Mission& mission_;
  std::map<long, Mark> ids_, tags_;
  std::vector<Pending> pending_;  ///< one for each of Mission::jumps
  std::optional<Speed> speed_;    ///< commanded since the last waypoint
};

}  // namespace landfix::mission
