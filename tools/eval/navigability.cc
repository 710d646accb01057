#include "tools/eval/navigability.h"

#include <cmath>
#include <regex>

#include "builder/ingest/provenance.h"
#include "runtime/nav/pack_map.h"
#include "tools/common/map_age.h"

namespace landfix::eval {
namespace {

std::optional<std::array<double, kTextures>> textures_at(const nav::MapSource& map, double east_m, double north_m,
                                                         double side_m, double gsd_m) {
  const double half_m = side_m / 2;
  features::GridImage window;
  if (map.read(nav::MapLayer::kGray, east_m - half_m, north_m - half_m, east_m + half_m, north_m + half_m, gsd_m,
               window) != nav::Status::kOk ||
      !window.valid.empty())
    return std::nullopt;
  return textures_of(window.pixels);
}

}  // namespace

double Foreseen::sigma_m() const { return std::sqrt((expected.covariance_m2[0] + expected.covariance_m2[3]) / 2); }

Sample Foreseen::sample() const {
  Sample s;
  s.answered = true;
  s.block = trial.question.block;
  s.probability = expected.fix_probability;
  s.hit = trial.hit();
  if (!trial.answered()) return s;
  s.error_m = trial.error_m();
  s.in_ellipse = in_95_ellipse(trial.east_m - trial.question.east_m, trial.north_m - trial.question.north_m,
                               expected.covariance_m2);
  return s;
}

std::vector<Foreseen> foresee(std::span<const Trial> trials, const Foresight& o) {
  const nav::PackMap map(o.pack);
  std::vector<Foreseen> out;
  for (const Trial& trial : trials) {
    const Question& q = trial.question;
    auto expected = o.navigability.between(q.east_m, q.north_m, o.finder);
    if (!expected) continue;
    Foreseen& f = out.emplace_back(Foreseen{trial, *expected, {}, {}});
    if (o.camera_day) f.age_years = tools::map_age_years(o.pack, q.east_m, q.north_m, *o.camera_day);
    if (f.age_years) f.expected.fix_probability = tiles::aged(expected->fix_probability, *f.age_years);
    f.textures = textures_at(map, q.east_m, q.north_m, o.template_m, o.gsd_m);
  }
  return out;
}

std::string date_in_name(const std::string& name) {
  static const std::regex kDate(R"((?:^|[^0-9])((?:19|20)[0-9]{2})([-_]?)([0-9]{2})\2([0-9]{2})(?![0-9]))");
  for (std::sregex_iterator it(name.begin(), name.end(), kDate), end; it != end; ++it) {
    const std::string date = (*it)[1].str() + "-" + (*it)[3].str() + "-" + (*it)[4].str();
    if (ingest::is_date(date)) return date;
  }
  return {};
}

tiles::Finder finder_of(const MatcherChoice& matcher) { return *tools::finder_named(matcher.name); }

}  // namespace landfix::eval
