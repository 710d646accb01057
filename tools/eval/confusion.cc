#include "tools/eval/confusion.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

namespace landfix::eval {
namespace {

constexpr double kQuantile = 1.959964;  // of the normal distribution, for 95 %

nlohmann::ordered_json json_of(const Share& s) {
  return {{"right", s.hits}, {"of", s.of}, {"share", s.share}, {"low", s.low}, {"high", s.high}};
}

}  // namespace

Share share_of(int hits, int of) {
  if (of == 0) return {0, 0, NAN, NAN, NAN};
  const double p = double(hits) / of, z2 = kQuantile * kQuantile / of;
  const double middle = (p + z2 / 2) / (1 + z2);
  const double half = kQuantile * std::sqrt(p * (1 - p) / of + z2 / (4 * of)) / (1 + z2);
  return {hits, of, p, middle - half, middle + half};
}

Share recognised(const Confusion& confusion, size_t label) {
  const auto& row = confusion[label];
  return share_of(row[label], std::accumulate(row.begin(), row.end(), 0));
}

Share recognised(const Confusion& confusion) {
  int hits = 0, of = 0;
  for (size_t k = 0; k < confusion.size(); ++k) {
    const Share s = recognised(confusion, k);
    hits += s.hits, of += s.of;
  }
  return share_of(hits, of);
}

std::string to_text(const Confusion& confusion) {
  std::string text = fmt::format("{:10}", "truth");
  for (const char* name : features::kLandmarkLabelNames) text += fmt::format("{:>10}", name);
  text += "   right, 95 % interval\n";
  for (size_t k = 0; k < confusion.size(); ++k) {
    const Share s = recognised(confusion, k);
    if (s.of == 0) continue;
    text += fmt::format("{:10}", features::kLandmarkLabelNames[k]);
    for (const int count : confusion[k]) text += fmt::format("{:>10}", count);
    text += fmt::format("   {:.1f} % ({:.1f} to {:.1f})\n", 100 * s.share, 100 * s.low, 100 * s.high);
  }
  const Share all = recognised(confusion);
  return text + fmt::format("of all: {} of {}, {:.1f} % ({:.1f} to {:.1f})\n", all.hits, all.of, 100 * all.share,
                            100 * all.low, 100 * all.high);
}

nlohmann::ordered_json to_json(const Confusion& confusion) {
  nlohmann::ordered_json classes;
  for (size_t k = 0; k < confusion.size(); ++k)
    if (const Share s = recognised(confusion, k); s.of > 0) classes[features::kLandmarkLabelNames[k]] = json_of(s);
  return {{"labels", features::kLandmarkLabelNames},
          {"confusion", confusion},
          {"classes", classes},
          {"overall", json_of(recognised(confusion))}};
}

std::string to_text(const landmarks::Judgement& judgement) {
  return to_text(judgement.confusion) +
         fmt::format("stated probabilities are off by {:.3f} (expected calibration error)\n",
                     judgement.calibration_error());
}

nlohmann::ordered_json to_json(const landmarks::Judgement& judgement) {
  nlohmann::ordered_json json = to_json(judgement.confusion);
  json["calibration_error"] = judgement.calibration_error();
  return json;
}

}  // namespace landfix::eval
