#include "builder/roads/road_model.h"

#include <fmt/format.h>

#include "builder/error.h"
#include "builder/file_bytes.h"
#include "builder/roads/road_model_bytes.h"
#include "builder/roads/road_scales.h"

namespace landfix::landmarks {
namespace {

features::BoostedTrees take(std::span<const uint8_t>& bytes, size_t numbers, const std::string& name) {
  features::BoostedTrees trees;
  size_t used = 0;
  const features::TreesError e = trees.parse(bytes, used);
  if (e == features::TreesError::kNone && trees.features() == numbers && trees.outputs() == 1) {
    bytes = bytes.subspan(used);
    return trees;
  }
  const std::string found = e == features::TreesError::kNone ? fmt::format("trees over {} numbers with {} answers",
                                                                           trees.features(), trees.outputs())
                                                             : features::text_of(e);
  throw Error(ExitCode::kBadInput,
              fmt::format("{}: expected a model of roads (trees over {} numbers), found {}; train one with `landfix "
                          "train-roads`",
                          name, numbers, found));
}

}  // namespace

std::vector<uint8_t> RoadModel::serialise() const {
  std::vector<uint8_t> out;
  for (const features::BoostedTrees* trees : {&colour.first, &colour.second, &gray.first, &gray.second}) {
    const std::vector<uint8_t> bytes = trees->serialise();
    out.insert(out.end(), bytes.begin(), bytes.end());
  }
  return out;
}

RoadModel parse_road_model(std::span<const uint8_t> bytes, const std::string& name) {
  RoadModel model;
  for (RoadModel::Judges* judges : {&model.colour, &model.gray}) {
    judges->first = take(bytes, features::kRoadProfileFeatures, name);
    judges->second = take(bytes, kRoadScaleFeatures, name);
  }
  if (!bytes.empty())
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected the end of the model of roads, found {} bytes more", name, bytes.size()));
  return model;
}

RoadModel read_road_model(const std::string& path) {
  return parse_road_model(bytes_of_file(path, "a model that `landfix train-roads` wrote"), path);
}

const RoadModel& default_road_model() {
  static const RoadModel kModel = parse_road_model(kRoadModelBytes, "the model that comes with landfix");
  return kModel;
}

}  // namespace landfix::landmarks
