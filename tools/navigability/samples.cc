// Draws samples that say what a place's evidence was and whether a camera of another date then found itself there:
// worlds in five seasons and years, each date in turn the camera over maps of the others. fit.py makes the model of
// builder/navigability of them. With images instead of worlds the model is put to the test on real ground.
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <CLI/CLI.hpp>
#include <bit>
#include <deque>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <vector>

#include "builder/ingest/image_set.h"
#include "builder/navigability/model.h"
#include "runtime/nav/image_map.h"
#include "runtime/nav/registration.h"
#include "tools/synth/random.h"
#include "tools/synth/world.h"

namespace {

using namespace landfix;
using features::GridImage;
using navigability::Footprint;
using navigability::Predictors;

constexpr int kRimPx = 8;
constexpr double kWorldM = 2000, kWorldGsdM = 2;

/// A place on several dates.
struct Ground {
  std::string name;
  std::vector<GridImage> dates;  ///< newest first
  std::vector<double> years;
  uint64_t seed = 0;
};

Ground world(uint64_t seed) {
  struct Date {
    synth::Season season;
    int year;
    double azimuth_deg, elevation_deg;
  };
  using enum synth::Season;
  static constexpr Date kDates[] = {{kSummer, 2020, 240, 35},
                                    {kSummer, 2018, 170, 50},
                                    {kAutumn, 2016, 235, 25},
                                    {kSpring, 2014, 200, 30},
                                    {kSummer, 2012, 150, 45}};
  Ground out{fmt::format("world {}", seed), {}, {}, seed};
  for (const Date& date : kDates) {
    synth::WorldOptions o;
    o.seed = seed;
    o.size_m = kWorldM;
    o.gsd_m = kWorldGsdM;
    o.season = date.season;
    o.year = date.year;
    o.sun_azimuth_deg = date.azimuth_deg;
    o.sun_elevation_deg = date.elevation_deg;
    o.near_infrared = true;
    const int side = int(kWorldM / kWorldGsdM);
    out.dates.push_back(synth::World(o).ortho({o.west_m, o.south_m + kWorldM, side, side, kWorldGsdM}));
    out.years.push_back(date.year);
  }
  return out;
}

/// What the files show, as a build reads it. Their dates have the form 2018-07-16.
Ground place(const std::vector<std::string>& paths, const std::vector<std::string>& dates) {
  std::vector<ingest::SourceOptions> sources;
  for (size_t i = 0; i < paths.size(); ++i) sources.push_back({.path = paths[i], .date = dates.at(i)});
  const ingest::ImageSet set(sources);
  const int level = set.derived_level();
  const double gsd = std::exp2(level);
  const ingest::GridBounds& b = set.bounds();
  const int column = int(std::floor(b.west_m / gsd)), row = int(std::floor(-b.north_m / gsd));
  const tiles::PixelRect rect{level, column, row, int(std::ceil(b.east_m / gsd)) - column,
                              int(std::ceil(-b.south_m / gsd)) - row};
  Ground out{"images", {}, {}, 0};
  for (ingest::Epoch& epoch : set.read(rect).epochs) {
    out.dates.push_back({epoch.bands, epoch.valid, column * gsd, -row * gsd, gsd});
    out.years.push_back(std::stod(epoch.date.substr(0, 4)) + (std::stod(epoch.date.substr(5, 2)) - 0.5) / 12);
  }
  return out;
}

std::vector<GridImage> chosen(const Ground& ground, unsigned mask) {
  std::vector<GridImage> out;
  for (size_t i = 0; i < ground.dates.size(); ++i)
    if (mask >> i & 1) out.push_back(ground.dates[i]);
  return out;
}

/// Which dates make the map, and which are the camera over it. Of drawn worlds one camera per map is enough.
std::vector<std::pair<unsigned, size_t>> experiments(const Ground& ground, bool all, int map_dates) {
  std::vector<std::pair<unsigned, size_t>> out;
  const size_t count = ground.dates.size();
  std::map<int, int> of_size;
  for (unsigned mask = 1; mask + 1 < 1u << count; ++mask) {
    if (map_dates > 0 && std::popcount(mask) != map_dates) continue;
    if (!all && ++of_size[std::popcount(mask)] > 5) continue;
    const size_t first = synth::key(ground.seed, 7, mask) % count;
    for (size_t i = 0, taken = 0; i < count && (all || taken == 0); ++i)
      if (const size_t camera = (first + i) % count; !(mask >> camera & 1)) out.emplace_back(mask, camera), ++taken;
  }
  return out;
}

GridImage view(const GridImage& image, double east_m, double north_m, int side_px) {
  const int half = side_px / 2 + kRimPx;
  const cv::Rect r(int(std::lround((east_m - image.west_m) / image.gsd_m)) - half,
                   int(std::lround((image.north_m - north_m) / image.gsd_m)) - half, 2 * half, 2 * half);
  GridImage out{{}, {}, -half * image.gsd_m, half * image.gsd_m, image.gsd_m};
  cv::Mat bands[4];
  cv::split(image.pixels(r), bands);
  cv::merge(bands, 3, out.pixels);
  if (!image.valid.empty()) out.valid = image.valid(r).clone();
  return out;
}

nav::Registration registered(nav::Registrar& registrar, const GridImage& patch, double east_m, double north_m,
                             double search_m) {
  nav::RegistrationPrior prior;
  prior.east_m = east_m;
  prior.north_m = north_m;
  prior.covariance_m2 = {search_m * search_m / 9, 0, 0, search_m * search_m / 9};
  nav::Registration out;
  registrar.run(patch, prior, out);
  return out;
}

/// The matcher whose evidence tells of it: `auto` begins with orientation.
nav::Method evidence_of(const std::optional<nav::Method>& method) { return method.value_or(nav::Method::kOrientation); }

const char* const kHeader =
    "method,ground,camera,dates,age_years,template_px,least_logit,mean_logit,structure,crest,background,views,found,"
    "accepted,"
    "covariance_ee,covariance_en,covariance_nn,gsd_m,hit,east_error_m,north_error_m,fix_accepted,probability,east_m,"
    "north_m\n";

/// What is drawn, beside the ground.
struct Draw {
  std::optional<nav::Method> method;  ///< absent: auto
  double spacing_m = 0;
  bool all = false;  ///< every camera over every map, not one each
  int map_dates = 0;
};

/// The evidence of a map at every place of a grid, and what cameras found there, for one footprint.
class Grid {
 public:
  Grid(const Ground& ground, const Footprint& footprint, const Draw& what)
      : ground_(ground), footprint_(footprint), what_(what) {}

  void judge(navigability::Witness& witness) {
    evidence_.clear();
    for_each_place([&](double east_m, double north_m) {
      evidence_.push_back(witness.at(east_m, north_m, footprint_, evidence_of(what_.method)));
    });
  }

  void match(nav::Registrar& registrar, size_t camera, double age_years) {
    const Footprint& f = footprint_;
    const GridImage& image = ground_.dates[camera];
    const int side = 2 * int(std::lround(0.5 * f.template_m / image.gsd_m));
    const std::string name = what_.method ? nav::name_of(*what_.method) : "auto";
    size_t place = 0;
    for_each_place([&](double east_m, double north_m) {
      const Predictors& p = evidence_[place++];
      const nav::Registration r =
          registered(registrar, view(image, east_m, north_m, side), east_m, north_m, f.search_m);
      const bool answered = r.status == nav::Status::kOk || r.status == nav::Status::kImprobable;
      const double de = r.peak.east_m - east_m, dn = r.peak.north_m - north_m;
      const auto& c = p.covariance_m2;
      fmt::print(
          rows_,
          "{},{},{},{},{:.2f},{},{:.4f},{:.4f},{:.5f},{:.5f},{:.5f},{},{:.3f},{:.3f},{:.3f},{:.3f},{:.3f},{},{},{:.3f},"
          "{:.3f},{},{:.5f},{:.1f},{:.1f}\n",
          name, ground_.name, camera, p.dates, age_years, p.template_px, p.least_logit, p.mean_logit, p.structure,
          p.crest, p.background, p.views, p.found, p.accepted, c[0], c[1], c[3], image.gsd_m,
          int(answered && std::hypot(de, dn) <= f.hit_m), answered ? de : 0, answered ? dn : 0,
          int(r.status == nav::Status::kOk), navigability::fix_probability(p, evidence_of(what_.method)), east_m,
          north_m);
    });
  }

  std::string rows() const { return rows_.str(); }

 private:
  template <typename Visit>
  void for_each_place(const Visit& visit) const {
    const GridImage& frame = ground_.dates[0];
    const double gsd = frame.gsd_m, margin = 0.5 * footprint_.template_m + footprint_.search_m + 2 * kRimPx * gsd;
    const double east_end = frame.west_m + frame.pixels.cols * gsd - margin,
                 south_end = frame.north_m - frame.pixels.rows * gsd + margin;
    for (double north = frame.north_m - margin; north >= south_end; north -= what_.spacing_m)
      for (double east = frame.west_m + margin; east <= east_end; east += what_.spacing_m) visit(east, north);
  }

  const Ground& ground_;
  const Footprint footprint_;
  const Draw& what_;
  std::vector<Predictors> evidence_;
  std::ostringstream rows_;
};

void draw(const Ground& ground, const std::vector<Footprint>& footprints, const Draw& what, std::ostream& out) {
  std::deque<Grid> grids;
  for (const Footprint& f : footprints) grids.emplace_back(ground, f, what);
  unsigned known = 0;
  const nav::Method method = evidence_of(what.method);
  for (const auto& [mask, camera] : experiments(ground, what.all, what.map_dates)) {
    const std::vector<GridImage> dates = chosen(ground, mask);
    const nav::MapLayer layers[] = {nav::layer_of(method)};
    const nav::ImageMap map = what.method ? nav::ImageMap(dates, 1, 0, layers) : nav::ImageMap(dates, 1, 0);
    nav::RegistrationOptions o;
    o.method = what.method;
    o.rim_px = kRimPx;
    nav::Registrar registrar(map, o);
    if (mask != known) {
      navigability::Witness witness(dates, std::span(&method, 1));
      for (Grid& grid : grids) grid.judge(witness);
    }
    known = mask;
    double age = 1e9;
    for (size_t i = 0; i < ground.years.size(); ++i)
      if (mask >> i & 1) age = std::min(age, std::abs(ground.years[i] - ground.years[camera]));
    for (Grid& grid : grids) grid.match(registrar, camera, age);
  }
  for (const Grid& grid : grids) out << grid.rows();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Samples to fit the model of navigability to, or to test it with, as CSV");
  std::string out_path;
  uint64_t first = 1;
  int worlds = 0, map_dates = 0;
  std::vector<std::string> images, dates;
  std::vector<double> template_px = {16, 24, 40};
  double search_px = 40, spacing_px = 50, hit_px = 3.75;
  std::string method = "orientation";
  app.add_option("-o,--output", out_path)->required();
  app.add_option("--first", first, "Seed of the first world");
  app.add_option("--worlds", worlds, "So many drawn worlds");
  app.add_option("--image", images, "Images instead of worlds");
  app.add_option("--date", dates, "Their dates, in the same order");
  app.add_option("--map-dates", map_dates, "Only maps of so many dates");
  app.add_option("--method", method, "auto, orientation, gray, edge or contour")
      ->check(CLI::IsMember({"auto", "orientation", "gray", "edge", "contour"}));
  app.add_option("--template-px", template_px);
  app.add_option("--search-px", search_px);
  app.add_option("--spacing-px", spacing_px);
  app.add_option("--hit-px", hit_px);
  CLI11_PARSE(app, argc, argv);
  try {
    std::ofstream out(out_path);
    out << kHeader;
    const auto draw_all = [&](const Ground& ground, bool all) {
      const double gsd = ground.dates.at(0).gsd_m;
      std::vector<Footprint> footprints;
      for (const double side : template_px) footprints.push_back({side * gsd, search_px * gsd, hit_px * gsd});
      draw(ground, footprints, {nav::method_of(method), spacing_px * gsd, all, map_dates}, out);
    };
    for (int i = 0; i < worlds; ++i) draw_all(world(first + uint64_t(i)), false);
    if (!images.empty()) draw_all(place(images, dates), true);
    if (!out.flush()) throw std::runtime_error(out_path + ": cannot be written");
  } catch (const std::exception& e) {
    std::cerr << e.what() << '\n';
    return 1;
  }
}
