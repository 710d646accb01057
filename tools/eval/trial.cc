#include "tools/eval/trial.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>

#include "builder/error.h"

namespace landfix::eval {

std::vector<MatcherChoice> matchers_named(const std::vector<std::string>& names) {
  std::vector<MatcherChoice> out;
  for (const std::string& name : names) {
    if (name == "all" || name == "auto") out.push_back({});
    if (name == "all")
      for (const nav::Method method : nav::kMethods) out.push_back({nav::name_of(method), method});
    if (name == "all" || name == "auto") continue;
    const std::optional<nav::Method> method = nav::method_of(name);
    if (!method)
      throw Error(ExitCode::kUsage,
                  fmt::format("--matcher {}: expected all, auto, gray, edge, contour or orientation", name));
    out.push_back({name, method});
  }
  return out;
}

double Trial::error_m() const { return std::hypot(east_m - question.east_m, north_m - question.north_m); }

Trial answer(nav::Registrar& registrar, const features::GridImage& patch, const Question& question,
             nav::Registration& found) {
  const auto begin = std::chrono::steady_clock::now();
  registrar.run(patch, question.prior, found);
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - begin;
  Trial trial;
  trial.question = question;
  trial.status = found.status;
  trial.method = found.method;
  trial.milliseconds = taken.count();
  if (!trial.answered()) return trial;
  trial.east_m = found.peak.east_m;
  trial.north_m = found.peak.north_m;
  trial.covariance_m2 = found.covariance_m2;
  trial.probability = found.probability;
  trial.evidence = found.evidence;
  trial.similarity = found.similarity;
  return trial;
}

Sample sample_of(const Trial& t) {
  Sample s;
  s.block = t.question.block;
  s.answered = t.answered();
  if (!s.answered) return s;
  s.hit = t.hit();
  s.error_m = t.error_m();
  s.probability = t.probability;
  s.gap = t.evidence.gap;
  s.in_ellipse = in_95_ellipse(t.east_m - t.question.east_m, t.north_m - t.question.north_m, t.covariance_m2);
  return s;
}

std::string_view word_of(nav::Status status) {
  switch (status) {
    case nav::Status::kOk:
      return "ok";
    case nav::Status::kNotStarted:
      return "not_started";
    case nav::Status::kNotFinite:
      return "not_finite";
    case nav::Status::kBadValue:
      return "bad_value";
    case nav::Status::kBadImage:
      return "bad_image";
    case nav::Status::kBelowGround:
      return "below_ground";
    case nav::Status::kNothingVisible:
      return "nothing_visible";
    case nav::Status::kTooLarge:
      return "too_large";
    case nav::Status::kTemplateTooLarge:
      return "template_too_large";
    case nav::Status::kNoTexture:
      return "no_texture";
    case nav::Status::kOutsideMap:
      return "outside_map";
    case nav::Status::kNoGroundHeight:
      return "no_ground_height";
    case nav::Status::kLost:
      return "lost";
    case nav::Status::kNoLayer:
      return "no_layer";
    case nav::Status::kMapError:
      return "map_error";
    case nav::Status::kImprobable:
      return "improbable";
    case nav::Status::kMapTooOld:
      return "map_too_old";
    case nav::Status::kInternal:
      return "internal";
  }
  return "internal";
}

std::string trial_csv_header() {
  return "camera,matcher,seed,east_m,north_m,rotation_error_deg,scale_error,status,method,hit,error_m,error_east_m,"
         "error_north_m,value,gap,spread,sigma_px,independent_pixels,similarities,probability,covariance_ee_m2,"
         "covariance_en_m2,"
         "covariance_nn_m2,rotation_found_deg,scale_found,block,ms\n";
}

std::string trial_csv_line(const std::string& matcher, const Trial& t) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const Question& q = t.question;
  std::string line =
      fmt::format("{},{},{},{:.3f},{:.3f},{:.4f},{:.5f},{},", q.camera, matcher, q.seed_index, q.east_m, q.north_m,
                  q.similarity.rotation_rad * kDegrees, q.similarity.scale - 1, word_of(t.status));
  if (!t.answered()) return line + ",0," + std::string(15, ',') + fmt::format("{:x},{:.3f}\n", q.block, t.milliseconds);
  line += fmt::format("{},{:d},{:.3f},{:.3f},{:.3f},", nav::name_of(t.method), t.hit(), t.error_m(),
                      t.east_m - q.east_m, t.north_m - q.north_m);
  line += fmt::format("{:.6f},{:.6f},{:.6f},{:.4f},{:.2f},{:.0f},{:.6f},", t.evidence.value, t.evidence.gap,
                      t.evidence.spread, t.evidence.sigma_px, t.evidence.independent_pixels, t.evidence.similarities,
                      t.probability);
  line += fmt::format("{:.5f},{:.5f},{:.5f},{:.4f},{:.5f},{:x},{:.3f}\n", t.covariance_m2[0],
                      0.5 * (t.covariance_m2[1] + t.covariance_m2[2]), t.covariance_m2[3],
                      t.similarity.rotation_rad * kDegrees, t.similarity.scale - 1, q.block, t.milliseconds);
  return line;
}

}  // namespace landfix::eval
