#include "builder/landmarks/object_model.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "builder/error.h"
#include "builder/file_bytes.h"
#include "builder/landmarks/object_model_bytes.h"
#include "builder/landmarks/object_regions.h"
#include "runtime/features/object_planes.h"

namespace landfix::landmarks {
namespace {

constexpr uint32_t kMagic = 0x424f464c, kVersion = 1;  // "LFOB"

class Reader {
 public:
  Reader(std::span<const uint8_t> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  uint32_t u32() {
    if (bytes_.size() < 4) fail("the file ends early");
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value |= uint32_t(bytes_[i]) << (8 * i);
    bytes_ = bytes_.subspan(4);
    return value;
  }
  features::BoostedTrees trees(size_t features, size_t outputs) {
    features::BoostedTrees out;
    size_t used = 0;
    const features::TreesError e = out.parse(bytes_, used);
    if (e != features::TreesError::kNone) fail(features::text_of(e));
    if (out.features() != features || out.outputs() != outputs)
      fail(fmt::format("trees over {} numbers with {} outputs instead of {} and {}", out.features(), out.outputs(),
                       features, outputs));
    bytes_ = bytes_.subspan(used);
    return out;
  }
  Sigmoid sigmoid() {
    const float a = std::bit_cast<float>(u32()), b = std::bit_cast<float>(u32());
    if (!std::isfinite(a) || !std::isfinite(b) || a > 0) fail("numbers out of their range");
    return {double(a), double(b)};
  }
  ObjectModel::Part part(size_t planes) {
    ObjectModel::Part out;
    out.covers = trees(planes, kCovers);
    for (features::BoostedTrees& t : out.whole) t = trees(kRegionNumbers, 1);
    for (Sigmoid& s : out.probability) s = sigmoid();
    return out;
  }
  bool at_end() const { return bytes_.empty(); }
  [[noreturn]] void fail(const std::string& found) const {
    throw Error(
        ExitCode::kBadInput,
        fmt::format("{}: expected a model of objects, found {}; train one with `landfix train-objects`", name_, found));
  }

 private:
  std::span<const uint8_t> bytes_;
  const std::string& name_;
};

void put(std::vector<uint8_t>& out, uint32_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(uint8_t(value >> (8 * i)));
}

void put(std::vector<uint8_t>& out, const features::BoostedTrees& trees) {
  const std::vector<uint8_t> bytes = trees.serialise();
  out.insert(out.end(), bytes.begin(), bytes.end());
}

}  // namespace

Cover cover_of(tiles::LandmarkClass cls) {
  switch (cls) {
    case tiles::LandmarkClass::kBuilding:
      return Cover::kBuilding;
    case tiles::LandmarkClass::kField:
      return Cover::kGround;
    case tiles::LandmarkClass::kTree:
      return Cover::kTree;
    case tiles::LandmarkClass::kWater:
      return Cover::kWater;
    case tiles::LandmarkClass::kPaved:
      return Cover::kPaved;
  }
  return Cover::kGround;
}

std::vector<uint8_t> ObjectModel::serialise() const {
  std::vector<uint8_t> out;
  put(out, kMagic);
  put(out, kVersion);
  for (const Part* part : {&colour, &gray}) {
    put(out, part->covers);
    for (const features::BoostedTrees& trees : part->whole) put(out, trees);
    for (const Sigmoid& s : part->probability) {
      put(out, std::bit_cast<uint32_t>(float(s.a)));
      put(out, std::bit_cast<uint32_t>(float(s.b)));
    }
  }
  return out;
}

ObjectModel parse_object_model(std::span<const uint8_t> bytes, const std::string& name) {
  Reader in(bytes, name);
  if (in.u32() != kMagic) in.fail("another kind of file");
  if (const uint32_t version = in.u32(); version != kVersion)
    in.fail(fmt::format("version {} where this landfix knows {}", version, kVersion));
  ObjectModel model;
  model.colour = in.part(features::kObjectPlanesColour);
  model.gray = in.part(features::kObjectPlanesGray);
  if (!in.at_end()) in.fail("bytes behind its end");
  return model;
}

ObjectModel read_object_model(const std::string& path) {
  return parse_object_model(bytes_of_file(path, "a model that `landfix train-objects` wrote"), path);
}

const ObjectModel& default_object_model() {
  static const ObjectModel kModel = parse_object_model(kObjectModelBytes, "the model that comes with landfix");
  return kModel;
}

}  // namespace landfix::landmarks
