#include "tools/route/pack_navigability.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "builder/error.h"
#include "tools/common/navigability_map.h"

namespace landfix::route {
namespace {

constexpr double kSearchSigmas = 3.72;  ///< of the belief that a search reaches (error_model.h)

Navigability from_node(const tiles::Navigability& node) {
  Navigability n;
  n.fix_probability = node.fix_probability[size_t(tiles::Finder::kAuto)];
  n.false_probability = std::min(node.false_probability, 1 - n.fix_probability);
  const std::array<double, 4> covariance_m2 = tools::covariance_of(node);
  n.covariance_m2 = Eigen::Map<const Eigen::Matrix2d>(covariance_m2.data());  // symmetric: either order
  for (const auto& [in_file, here] : kReasonsOfMaps)
    if (node.has(in_file)) n.reasons |= here;
  if (node.has(tiles::Reason::kRepeats) && node.rival_m > 0) n.repeat = Repeat{node.rival_m, node.rival_bearing_rad};
  return n;
}

/// Both, `share` of the second.
Navigability between(const Navigability& a, const Navigability& b, double share) {
  Navigability n = share < 0.5 ? a : b;
  n.fix_probability = a.fix_probability + share * (b.fix_probability - a.fix_probability);
  n.false_probability = a.false_probability + share * (b.false_probability - a.false_probability);
  n.covariance_m2 = a.covariance_m2 + share * (b.covariance_m2 - a.covariance_m2);
  return n;
}

class PackNavigability : public NavigabilityMap {
 public:
  PackNavigability(const Pack& pack, const std::string& path, std::optional<int> day) : day_(day) {
    for (const tiles::Footprint& footprint : tools::footprints_of(pack)) maps_.emplace_back(pack, footprint, path);
    if (maps_.empty()) {
      throw Error(ExitCode::kNoData, path +
                                         ": expected a pack with navigability, found none in it; build it with "
                                         "--navigability VIEW/SEARCH");
    }
    for (const tools::NavigabilityMap& map : maps_)
      if (views_m_.empty() || views_m_.back() < map.footprint().template_m)
        views_m_.push_back(map.footprint().template_m);
  }

  std::optional<Navigability> at(double east_m, double north_m, double footprint_m, double search_m) const override {
    const auto above = std::upper_bound(views_m_.begin(), views_m_.end(), footprint_m);
    if (above == views_m_.begin()) {
      std::optional<Navigability> n = of_view(views_m_.front(), east_m, north_m, search_m);
      const double share = footprint_m / views_m_.front();
      if (n) n->fix_probability *= share * share;
      return n;
    }
    const std::optional<Navigability> smaller = of_view(*(above - 1), east_m, north_m, search_m);
    if (above == views_m_.end() || !smaller) return smaller;
    const std::optional<Navigability> larger = of_view(*above, east_m, north_m, search_m);
    if (!larger) return smaller;
    return between(*smaller, *larger, std::log(footprint_m / *(above - 1)) / std::log(*above / *(above - 1)));
  }

  Extent extent() const override {
    Extent all{INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (const tools::NavigabilityMap& map : maps_) {
      all.west_m = std::min(all.west_m, map.west_m());
      all.north_m = std::max(all.north_m, map.north_m());
      all.east_m = std::max(all.east_m, map.west_m() + map.columns() * map.spacing_m());
      all.south_m = std::min(all.south_m, map.north_m() - map.rows() * map.spacing_m());
    }
    return all;
  }

 private:
  /// Of the maps of one view, which stand by growing search, the first that is wide enough, or the last.
  std::optional<Navigability> of_view(double view_m, double east_m, double north_m, double search_m) const {
    const tools::NavigabilityMap* chosen = nullptr;
    for (const tools::NavigabilityMap& map : maps_) {
      if (map.footprint().template_m != view_m) continue;
      chosen = &map;
      if (map.footprint().search_m >= search_m) break;
    }
    const std::optional<tiles::Navigability> node = chosen->at(east_m, north_m);
    if (!node || std::isnan(node->fix_probability[size_t(tiles::Finder::kAuto)])) return std::nullopt;
    Navigability n = from_node(day_ ? tiles::on_day(*node, *day_) : *node);
    const double reached = chosen->footprint().search_m / search_m;
    if (reached < 1) {
      const double inside = std::erf(reached * kSearchSigmas / M_SQRT2);
      n.fix_probability *= inside * inside;
    }
    return n;
  }

  std::optional<int> day_;
  std::vector<tools::NavigabilityMap> maps_;
  std::vector<double> views_m_;  ///< growing
};

}  // namespace

std::unique_ptr<NavigabilityMap> open_navigability(const Pack& pack, const std::string& path, std::optional<int> day) {
  return std::make_unique<PackNavigability>(pack, path, day);
}

}  // namespace landfix::route
