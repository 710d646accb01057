#include "builder/ingest/roles.h"

#include <cpl_string.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace landfix::ingest {
namespace {

constexpr std::array kRoles = {BandRole::kGray, BandRole::kRed, BandRole::kGreen, BandRole::kBlue, BandRole::kNir};

using Assignment = std::vector<std::pair<BandRole, int>>;

BandLayout layout_of(Assignment assignment, int alpha) {
  std::sort(assignment.begin(), assignment.end());
  BandLayout layout;
  layout.alpha = alpha;
  for (const auto& [role, band] : assignment) {
    layout.roles.push_back(role);
    layout.bands.push_back(band);
  }
  return layout;
}

BandLayout layout_from_text(const std::string& path, const std::string& text, int band_count, ExitCode code) {
  const auto refuse = [&](const std::string& why) -> Error {
    return Error(
        code,
        fmt::format("{}: bands \"{}\": {}. Expected one of gray, red, green, blue, nir, alpha or - for each of the "
                    "{} bands, for instance nir,red,green",
                    path, text, why, band_count));
  };
  const CPLStringList names(
      CSLTokenizeString2(text.c_str(), ",", CSLT_ALLOWEMPTYTOKENS | CSLT_STRIPLEADSPACES | CSLT_STRIPENDSPACES));
  if (names.size() != band_count) throw refuse(fmt::format("{} names", names.size()));
  Assignment assignment;
  int alpha = 0;
  for (int i = 0; i < names.size(); ++i) {
    const std::string name = names[i];
    if (name == "-") continue;
    if (name == "alpha") {
      if (alpha != 0) throw refuse("alpha is named twice");
      alpha = i + 1;
      continue;
    }
    const auto known = std::find_if(kRoles.begin(), kRoles.end(), [&](BandRole role) { return name_of(role) == name; });
    if (known == kRoles.end()) throw refuse(fmt::format("\"{}\" is no band", name));
    if (std::any_of(assignment.begin(), assignment.end(), [&](const auto& a) { return a.first == *known; })) {
      throw refuse(fmt::format("{} is named twice", name));
    }
    assignment.emplace_back(*known, i + 1);
  }
  if (assignment.empty()) throw refuse("no band is left");
  if (assignment.size() > 4) throw refuse("more than four bands");
  return layout_of(assignment, alpha);
}

std::optional<BandRole> colour_of(GDALColorInterp interpretation) {
  switch (interpretation) {
    case GCI_RedBand:
      return BandRole::kRed;
    case GCI_GreenBand:
      return BandRole::kGreen;
    case GCI_BlueBand:
      return BandRole::kBlue;
    default:
      return std::nullopt;
  }
}

// What bands show that do not say it, in this order.
constexpr std::array kUsual = {BandRole::kRed, BandRole::kGreen, BandRole::kBlue, BandRole::kNir};

BandLayout layout_from_file(GDALDataset& dataset, const std::string& path) {
  Assignment colours;
  std::vector<int> others, all;
  int alpha = 0;
  for (int band = 1; band <= dataset.GetRasterCount(); ++band) {
    const GDALColorInterp interpretation = dataset.GetRasterBand(band)->GetColorInterpretation();
    if (interpretation == GCI_AlphaBand && alpha == 0) {
      alpha = band;
      continue;
    }
    const auto colour = colour_of(interpretation);
    if (colour) {
      colours.emplace_back(*colour, band);
    } else {
      others.push_back(band);
    }
    all.push_back(band);
  }
  std::sort(colours.begin(), colours.end());
  const bool rgb = colours.size() == 3 && colours[0].first == BandRole::kRed && colours[1].first == BandRole::kGreen &&
                   colours[2].first == BandRole::kBlue;
  if (rgb && others.size() <= 1) {
    if (!others.empty()) colours.emplace_back(BandRole::kNir, others[0]);
    return layout_of(colours, alpha);
  }
  if (all.size() == 1) return layout_of({{BandRole::kGray, all[0]}}, alpha);
  Assignment usual;
  for (size_t i = 0; i < all.size(); ++i)
    if (i < kUsual.size()) usual.emplace_back(kUsual[i], all[i]);
  const bool is_usual = std::ranges::includes(usual, colours);
  if ((all.size() == 3 || all.size() == 4) && is_usual) return layout_of(usual, alpha);
  throw Error(ExitCode::kBadInput,
              fmt::format("{}: has {} bands and does not say clearly what they show. Say it with --bands "
                          "{}=red,green,blue,nir (a name for each "
                          "band, - for one to leave out) or with \"bands\" in {}.json",
                          path, dataset.GetRasterCount(), path, path));
}

}  // namespace

BandLayout band_layout(GDALDataset& dataset, const std::string& path, const std::string& text, ExitCode code) {
  if (text.empty()) return layout_from_file(dataset, path);
  return layout_from_text(path, text, dataset.GetRasterCount(), code);
}

}  // namespace landfix::ingest
