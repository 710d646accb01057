#include "tools/synth/palette.h"

#include <array>

#include "tools/synth/random.h"

namespace landfix::synth {
namespace {

constexpr size_t kSeasons = 4;
constexpr int kRotatingCrops = 9;  // the crops before kGrass

size_t index(Season season) { return static_cast<size_t>(season); }

/// Ploughed or harrowed soil: passes show, the soil's own patches dominate.
Paint bare(float r, float g, float b) { return {{r, g, b, r * 0.95f}, 0.26f, 0.06f, 0, 0, 3.2f, 0.05f, false}; }
/// Young rows on soil.
Paint rows(float r, float g, float b, float row_m) { return {{r, g, b, r}, 0.26f, 0.1f, row_m, 0.1f, 6, 0.02f, false}; }
/// A closed stand of plants.
Paint stand(float r, float g, float b, float nir) { return {{r, g, b, nir}, -0.12f, 0.15f, 0, 0, 3, 0.03f, true}; }
/// Stubble after harvest: swaths.
Paint stubble(float r, float g, float b) { return {{r, g, b, r * 0.9f}, 0.1f, 0.1f, 0, 0, 7.5f, 0.07f, false}; }
Paint meadow(float r, float g, float b, float nir) { return {{r, g, b, nir}, -0.11f, 0.16f, 0, 0, 0, 0, false}; }
Paint mown(float r, float g, float b, float nir) { return {{r, g, b, nir}, -0.1f, 0.12f, 0, 0, 5, 0.05f, false}; }

}  // namespace

std::string name_of(Season season) {
  constexpr std::array<const char*, kSeasons> kNames = {"spring", "summer", "autumn", "winter"};
  return kNames[index(season)];
}

std::string date_of(int year, Season season) {
  constexpr std::array<const char*, kSeasons> kDays = {"-05-02", "-07-15", "-10-10", "-01-20"};
  return std::to_string(year) + kDays[index(season)];
}

Crop crop_in_year(const Parcel& parcel, int year) {
  const int start = static_cast<int>(parcel.rotation_start);
  if (start >= kRotatingCrops) return parcel.rotation_start;
  return static_cast<Crop>(((start + year) % kRotatingCrops + kRotatingCrops) % kRotatingCrops);
}

Paint field_paint(Crop crop, Season season) {
  // Rows in the order of Crop, columns spring, summer, autumn, winter.
  static const std::array<std::array<Paint, kSeasons>, 11> kPaints = {{
      {stand(92, 118, 66, 195), stand(194, 170, 112, 150), bare(132, 108, 84), rows(106, 116, 74, 0.5f)},
      {stand(186, 176, 74, 190), stand(152, 134, 92, 140), stand(92, 116, 70, 180), stand(92, 108, 66, 150)},
      {stand(108, 130, 76, 185), stubble(202, 184, 136), meadow(98, 112, 70, 170), bare(118, 104, 84)},
      {bare(152, 126, 98), stand(70, 98, 56, 200), stubble(176, 154, 110), stubble(140, 124, 98)},
      {rows(140, 124, 92, 0.9f), stand(92, 122, 70, 205), stand(94, 114, 68, 180), bare(108, 92, 74)},
      {bare(162, 138, 106), stand(142, 134, 72, 185), stand(94, 78, 60, 90), stubble(126, 108, 86)},
      {meadow(100, 130, 72, 200), mown(122, 140, 88, 190), meadow(102, 126, 70, 170), meadow(112, 114, 76, 130)},
      {rows(130, 106, 82, 0.75f), rows(76, 108, 58, 0.75f), bare(148, 124, 98), bare(126, 108, 86)},
      {meadow(126, 128, 84, 150), meadow(156, 146, 102, 150), meadow(144, 132, 96, 140), meadow(130, 120, 92, 120)},
      {meadow(108, 130, 76, 195), mown(126, 140, 80, 180), meadow(114, 126, 70, 170), meadow(116, 114, 76, 130)},
      {meadow(110, 130, 78, 190), meadow(128, 138, 84, 175), meadow(118, 124, 74, 160), meadow(114, 112, 76, 125)},
  }};
  return kPaints.at(static_cast<size_t>(crop))[index(season)];
}

Colour grass_colour(Season season) {
  static const std::array<Colour, kSeasons> kGrass = {
      {{110, 130, 78, 190}, {130, 138, 84, 170}, {118, 124, 74, 160}, {118, 112, 78, 125}}};
  return kGrass[index(season)];
}

Colour water_colour(Season season) {
  static const std::array<Colour, kSeasons> kWater = {
      {{58, 78, 80, 14}, {46, 70, 70, 10}, {52, 68, 70, 12}, {62, 76, 84, 16}}};
  return kWater[index(season)];
}

Colour crown_colour(const Tree& tree, Season season, float variety) {
  static const std::array<Colour, kSeasons> kConifer = {
      {{58, 78, 52, 130}, {54, 76, 50, 135}, {56, 74, 50, 130}, {58, 72, 52, 120}}};
  static const std::array<Colour, kSeasons> kFirst = {
      {{92, 126, 58, 215}, {66, 98, 48, 220}, {132, 112, 52, 170}, {104, 94, 78, 100}}};
  static const std::array<Colour, kSeasons> kSecond = {
      {{112, 136, 74, 205}, {86, 112, 58, 210}, {150, 92, 46, 165}, {118, 106, 90, 105}}};
  if (tree.conifer) return kConifer[index(season)] * (0.85f + 0.3f * variety);
  return kFirst[index(season)] * (1 - variety) + kSecond[index(season)] * variety;
}

float crown_opacity(const Tree& tree, Season season) {
  return season == Season::kWinter && !tree.conifer ? 0.5f : 0.97f;
}

Colour roof_colour(const Building& building) {
  static const std::array<Colour, 4> kFlat = {
      {{156, 154, 150, 145}, {196, 194, 188, 185}, {112, 112, 114, 100}, {140, 132, 124, 130}}};
  static const std::array<Colour, 5> kGabled = {
      {{166, 98, 76, 150}, {146, 84, 66, 140}, {128, 96, 80, 130}, {104, 102, 104, 100}, {176, 116, 90, 160}}};
  static const std::array<Colour, 3> kBarn = {{{166, 164, 160, 150}, {136, 116, 102, 130}, {150, 92, 72, 140}}};
  const uint64_t pick = mix(building.key);
  if (building.roof == Roof::kFlat) return kFlat[pick % kFlat.size()];
  const bool barn = building.width_m > 11.5 || building.length_m > 22;
  return barn ? kBarn[pick % kBarn.size()] : kGabled[pick % kGabled.size()];
}

}  // namespace landfix::synth
