// Ingest of images: what they become on the grid, and what is refused, with which words.
#include <gdalwarper.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

#include "builder/ingest/hash.h"
#include "builder/ingest/zone.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix::ingest {
namespace {

// ----------------------------------------------------------------------------------------------------------------

TEST_F(Ingest, SameGridIsCopied) {
  // The file's pixels are the grid's: every value must come through unchanged, channels in the order red, green, blue.
  const std::string file = write("a.tif", {});
  const ImageSet set = images({{file}});
  EXPECT_EQ(zone_text(set.zone()), "32N");
  EXPECT_EQ(set.derived_level(), -1);
  // The scale factor on the central meridian is 0.9996: half a metre on the grid is 0.5002 m on the ground.
  EXPECT_NEAR(set.finest_gsd_m(), 0.5 / 0.9996, 1e-6);
  const tiles::PixelRect rect = pixels_covering(set.bounds(), -1);
  EXPECT_EQ(rect, (tiles::PixelRect{-1, 1'000'000, -10'400'000, 64, 48}));
  const Stack stack = set.read(rect);
  ASSERT_EQ(stack.epochs.size(), 1u);
  const Epoch& e = stack.epochs[0];
  EXPECT_EQ(e.roles, (std::vector<BandRole>{BandRole::kRed, BandRole::kGreen, BandRole::kBlue}));
  EXPECT_EQ(cv::countNonZero(e.valid), 64 * 48);
  for (int row = 0; row < 48; ++row) {
    for (int column = 0; column < 64; ++column) {
      for (int band = 0; band < 3; ++band) {
        ASSERT_EQ(e.bands.at<cv::Vec3b>(row, column)[band], (17 * (band + 1) + 3 * column + 5 * row) % 256);
      }
    }
  }
}

TEST_F(Ingest, OtherCrsLandsWhereProjSaysItDoes) {
  // A bright spot at a known place of each CRS: its centroid on the grid must be that place, to a twentieth of a pixel.
  struct Case {
    const char* crs;
    double west, north, pixel;
  };
  for (const Case& c : {Case{"EPSG:3857", 1'000'000, 5'950'000, 0.7}, Case{"EPSG:4326", 8.98, 47.06, 5e-6},
                        Case{"EPSG:2056", 2'690'000, 1'234'200, 0.5}, Case{"EPSG:32631", 952'000, 5'225'000, 0.5}}) {
    Sketch sketch;
    sketch.crs = c.crs;
    sketch.bands = 1;
    sketch.width = sketch.height = 200;
    const double transform[] = {c.west, c.pixel, 0, c.north, 0, -c.pixel};
    std::copy(transform, transform + 6, sketch.geotransform);
    sketch.value = [](int, int column, int row) {
      return std::round(220 * std::exp(-(std::pow(column - 120.0, 2) + std::pow(row - 70.0, 2)) / 50));
    };
    double x = c.west + 120.5 * c.pixel, y = c.north - 70.5 * c.pixel;
    transform_point(c.crs, kZone32, x, y);
    const ImageSet set = images({{write("spot.tif", sketch)}}, kZone32);
    const tiles::PixelRect rect = pixels_covering(set.bounds(), -1);
    const Stack stack = set.read(rect);
    ASSERT_EQ(stack.epochs.size(), 1u) << c.crs;
    double sum = 0, sum_x = 0, sum_y = 0;
    for (int row = 0; row < rect.height; ++row) {
      for (int column = 0; column < rect.width; ++column) {
        const double v = stack.epochs[0].bands.at<uchar>(row, column);
        sum += v;
        sum_x += v * (rect.west_m() + (column + 0.5) * 0.5);
        sum_y += v * (rect.north_m() - (row + 0.5) * 0.5);
      }
    }
    EXPECT_NEAR(sum_x / sum, x, 0.025) << c.crs;
    EXPECT_NEAR(sum_y / sum, y, 0.025) << c.crs;
  }
}

TEST_F(Ingest, MercatorMetresAreNotGroundMetres) {
  // At 47 degrees north a Mercator pixel of 1 m is about cos(47) = 0.68 m; the nearest level is 0.5 m.
  Sketch sketch;
  sketch.crs = "EPSG:3857";
  const double transform[] = {1'000'000, 1, 0, 5'942'000, 0, -1};
  std::copy(transform, transform + 6, sketch.geotransform);
  const ImageSet set = images({{write("m.tif", sketch)}});
  EXPECT_NEAR(set.finest_gsd_m(), std::cos(47.04 * kDegree), 0.003);
  EXPECT_EQ(set.derived_level(), -1);
}

TEST_F(Ingest, CoarserLevelsAverage) {
  // Every eighth column is 160, at 0.5 m: at 4 m a pixel's kernel covers two periods, so that all pixels are 160 / 8
  // = 20. Taking single source pixels, or the two neighbours of a centre, would give 0.
  Sketch sketch;
  sketch.width = sketch.height = 512;
  sketch.bands = 1;
  sketch.value = [](int, int column, int) { return column % 8 == 0 ? 160.0 : 0.0; };
  const ImageSet set = images({{write("stripes.tif", sketch)}});
  const GridBounds inner{500'032, 5'199'776, 500'224, 5'199'968};
  const Stack stack = set.read(pixels_covering(inner, 2));
  ASSERT_EQ(stack.epochs.size(), 1u);
  double least, most;
  cv::minMaxLoc(stack.epochs[0].bands, &least, &most);
  EXPECT_EQ(least, 20);
  EXPECT_EQ(most, 20);
}

TEST_F(Ingest, AValueDoesNotDependOnTheWindow) {
  // Overlapping windows, with and without the masked corner and across several cells, must agree to the bit; so must
  // threads.
  Sketch sketch;
  sketch.crs = "EPSG:2056";
  sketch.width = 1500;
  sketch.height = 400;
  sketch.bands = 4;
  const double transform[] = {2'690'000, 0.5, 0, 1'234'200, 0, -0.5};
  std::copy(transform, transform + 6, sketch.geotransform);
  sketch.value = [](int band, int column, int row) {
    return column < 300 && row < 100 ? 0.0 : 1 + (column * 7919 + row * 104729 + band * 31 + column * row) % 255;
  };
  sketch.finish = [](GDALDataset& d) {
    for (int band = 1; band <= 4; ++band) d.GetRasterBand(band)->SetNoDataValue(0);
  };
  const ImageSet set = images({{write("w.tif", sketch)}}, kZone32);
  for (const int level : {-1, 1}) {
    const tiles::PixelRect all = pixels_covering(set.bounds(), level);
    const Stack whole = set.read(all);
    ASSERT_EQ(whole.epochs.size(), 1u);
    tbb::parallel_for(0, 40, [&](int i) {
      const cv::Rect r = cv::Rect((i * 131) % int(all.width - 20), (i * 37) % int(all.height - 20), 20 + (i * 53) % 400,
                                  20 + (i * 29) % 200) &
                         cv::Rect(0, 0, int(all.width), int(all.height));
      const Stack part = set.read(tiles::PixelRect{level, all.column + r.x, all.row + r.y, r.width, r.height});
      const cv::Mat valid = whole.epochs[0].valid(r), bands = whole.epochs[0].bands(r);
      if (part.epochs.empty()) {
        EXPECT_EQ(cv::countNonZero(valid), 0);
        return;
      }
      EXPECT_EQ(cv::norm(part.epochs[0].valid, valid, cv::NORM_INF), 0) << i;
      EXPECT_EQ(cv::norm(part.epochs[0].bands, bands, cv::NORM_INF), 0) << i;
    });
  }
}

TEST_F(Ingest, ATruncatedHalfIsAnErrorNotBlackPixels) {
  struct Case {
    const char* name;
    std::vector<std::string> creation;
  };
  for (const Case& c : {Case{"plain.tif", {}}, Case{"deflate.tif", {"COMPRESS=DEFLATE", "TILED=YES"}},
                        Case{"jpeg.tif", {"COMPRESS=JPEG", "TILED=YES", "PHOTOMETRIC=YCBCR"}}}) {
    Sketch sketch;
    sketch.width = sketch.height = 600;
    sketch.creation = c.creation;
    sketch.value = [](int band, int column, int row) { return (column * 7919 + row * 104729 + band) % 251; };
    const std::string file = write(c.name, sketch);
    // The directory lies at the beginning: the file still opens.
    std::filesystem::resize_file(file, std::filesystem::file_size(file) * 6 / 10);
    const ImageSet set = images({{file}});
    expect_error(ExitCode::kIo, {c.name, "reading", "truncated"}, [&] { set.read(pixels_covering(set.bounds(), -1)); });
  }
}

TEST_F(Ingest, AgreesWithGdalsExactWarp) {
  // Reference made here by GDAL itself: the exact transformer, bilinear. The same up to rounding of halves.
  Sketch sketch;
  sketch.crs = "EPSG:3857";
  sketch.width = sketch.height = 300;
  const double transform[] = {1'000'000, 0.7, 0, 5'942'000, 0, -0.7};
  std::copy(transform, transform + 6, sketch.geotransform);
  sketch.value = [](int band, int column, int row) {
    return (column * 7919 + row * 104729 + band * 31 + column * row) % 256;
  };
  const std::string file = write("reference.tif", sketch);
  const ImageSet set = images({{file}}, kZone32);
  const tiles::PixelRect rect = pixels_covering(set.bounds(), -1);
  const Epoch ours = set.read(rect).epochs.at(0);
  GDALDriver* memory = GetGDALDriverManager()->GetDriverByName("MEM");
  const GDALDatasetUniquePtr theirs(memory->Create("", int(rect.width), int(rect.height), 3, GDT_Byte, nullptr));
  double geotransform[] = {rect.west_m(), 0.5, 0, rect.north_m(), 0, -0.5};
  theirs->SetGeoTransform(geotransform);
  OGRSpatialReference crs;
  crs.importFromEPSG(32632);
  theirs->SetSpatialRef(&crs);
  const GDALDatasetUniquePtr source(GDALDataset::Open(file.c_str()));
  ASSERT_EQ(
      GDALReprojectImage(source.get(), nullptr, theirs.get(), nullptr, GRA_Bilinear, 0, 0, nullptr, nullptr, nullptr),
      CE_None);
  int64_t compared = 0, different = 0;
  for (int band = 0; band < 3; ++band) {
    cv::Mat reference(int(rect.height), int(rect.width), CV_8UC1);
    ASSERT_EQ(theirs->GetRasterBand(band + 1)->RasterIO(GF_Read, 0, 0, reference.cols, reference.rows, reference.data,
                                                        reference.cols, reference.rows, GDT_Byte, 0, 0, nullptr),
              CE_None);
    for (int row = 2; row < reference.rows - 2; ++row) {
      for (int column = 2; column < reference.cols - 2; ++column) {
        // Not at the border, where GDAL takes one neighbour fewer.
        if (!ours.valid.at<uchar>(row - 2, column) || !ours.valid.at<uchar>(row + 2, column) ||
            !ours.valid.at<uchar>(row, column - 2) || !ours.valid.at<uchar>(row, column + 2)) {
          continue;
        }
        const int difference =
            std::abs(int(reference.at<uchar>(row, column)) - int(ours.bands.at<cv::Vec3b>(row, column)[band]));
        ASSERT_LE(difference, 1) << row << " " << column;
        ++compared;
        different += difference;
      }
    }
  }
  EXPECT_GT(compared, 3 * 150 * 150);
  EXPECT_LT(double(different), 0.01 * double(compared));
}

// -------------------------------------------------------------------------------------------------------

TEST_F(Ingest, DamagedJpegIsAnErrorNotGrayPixels) {
  // Zeros over some bytes in the middle: libjpeg only warns and makes something up.
  Sketch sketch;
  sketch.width = sketch.height = 600;
  sketch.creation = {"COMPRESS=JPEG", "TILED=YES", "PHOTOMETRIC=YCBCR"};
  sketch.value = [](int band, int column, int row) { return (column * 7919 + row * 104729 + band) % 251; };
  const std::string file = write("damaged.tif", sketch);
  {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(std::streamoff(std::filesystem::file_size(file) / 2));
    stream.write("\xff\xd9", 2);  // end of image
  }
  const ImageSet set = images({{file}});
  expect_error(ExitCode::kIo, {"damaged.tif", "JPEG"}, [&] { set.read(pixels_covering(set.bounds(), -1)); });
}

TEST_F(Ingest, NodataCountsOnlyWhereAllBandsHaveIt) {
  // Column 0 is 0 in all bands: no data. Column 1 is 0 in red alone: data. Whole-pixel copy, so that nothing is
  // blended.
  Sketch sketch;
  sketch.value = [](int band, int column, int) {
    return column == 0 || (column == 1 && band == 1) ? 0.0 : 50.0 * band;
  };
  sketch.finish = [](GDALDataset& d) {
    for (int band = 1; band <= 3; ++band) d.GetRasterBand(band)->SetNoDataValue(0);
  };
  const ImageSet set = images({{write("nodata.tif", sketch)}});
  const Stack stack = set.read(pixels_covering(set.bounds(), -1));
  const Epoch& e = stack.epochs.at(0);
  EXPECT_EQ(e.valid.at<uchar>(5, 0), 0);
  EXPECT_EQ(e.valid.at<uchar>(5, 1), 255);
  EXPECT_EQ(e.bands.at<cv::Vec3b>(5, 1), cv::Vec3b(0, 100, 150));
  EXPECT_EQ(cv::countNonZero(e.valid), 63 * 48);
}

TEST_F(Ingest, NodataCanBeGiven) {
  // The file says nothing about its black hole; the option or the sidecar does.
  Sketch sketch;
  sketch.value = [](int, int column, int) { return column < 10 ? 0.0 : 80.0; };
  const std::string file = write("hole.tif", sketch);
  const auto valid_pixels = [&](const SourceOptions& options) {
    const ImageSet set = images({options});
    return cv::countNonZero(set.read(pixels_covering(set.bounds(), -1)).epochs.at(0).valid);
  };
  EXPECT_EQ(valid_pixels({file}), 64 * 48);
  SourceOptions options{file};
  options.nodata = 0;
  EXPECT_EQ(valid_pixels(options), 54 * 48);
  write_text("hole.tif.json", R"({"nodata": 0})");
  EXPECT_EQ(valid_pixels({file}), 54 * 48);
  options.nodata = 300;
  expect_error(ExitCode::kUsage, {"hole.tif", "300", "0 to 255"}, [&] { images({options}); });
}

TEST_F(Ingest, AlphaAndDatasetMaskHide) {
  Sketch sketch;
  sketch.bands = 4;
  sketch.value = [](int band, int column, int) { return band < 4 ? 90.0 : column < 20 ? 127.0 : 128.0; };
  sketch.creation = {"ALPHA=YES"};
  const ImageSet alpha = images({{write("alpha.tif", sketch)}});
  EXPECT_EQ(alpha.sources()[0].bands.size(), 3u);
  EXPECT_EQ(cv::countNonZero(alpha.read(pixels_covering(alpha.bounds(), -1)).epochs.at(0).valid), 44 * 48);

  CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
  Sketch masked;
  masked.finish = [](GDALDataset& d) {
    d.CreateMaskBand(GMF_PER_DATASET);
    std::vector<uchar> line(64, 255);
    std::fill(line.begin(), line.begin() + 7, uchar(0));
    for (int row = 0; row < 48; ++row) {
      EXPECT_EQ(d.GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, row, 64, 1, line.data(), 64, 1, GDT_Byte, 0, 0,
                                                            nullptr),
                CE_None);
    }
  };
  const ImageSet mask = images({{write("mask.tif", masked)}});
  CPLSetThreadLocalConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  EXPECT_EQ(cv::countNonZero(mask.read(pixels_covering(mask.bounds(), -1)).epochs.at(0).valid), 57 * 48);
}

TEST_F(Ingest, BandRoles) {
  const auto roles = [&](int bands, const std::string& text) {
    Sketch sketch;
    sketch.bands = bands;
    sketch.creation = {"PHOTOMETRIC=MINISBLACK"};
    const ImageSet set = images({{write("roles.tif", sketch), "", text, ""}});
    return set.sources()[0].bands;
  };
  using enum BandRole;
  EXPECT_EQ(roles(1, ""), (std::vector{kGray}));
  EXPECT_EQ(roles(3, ""), (std::vector{kRed, kGreen, kBlue}));
  EXPECT_EQ(roles(4, ""), (std::vector{kRed, kGreen, kBlue, kNir}));
  EXPECT_EQ(roles(3, "nir,red,green"), (std::vector{kRed, kGreen, kNir}));
  EXPECT_EQ(roles(5, "-,blue,green,red,-"), (std::vector{kRed, kGreen, kBlue}));
  expect_error(ExitCode::kBadInput, {"roles.tif", "5 bands", "--bands"}, [&] { roles(5, ""); });
  expect_error(ExitCode::kBadInput, {"2 bands", "--bands"}, [&] { roles(2, ""); });
  expect_error(ExitCode::kUsage, {"2 names", "3 bands"}, [&] { roles(3, "red,green"); });
  expect_error(ExitCode::kUsage, {"\"purple\""}, [&] { roles(3, "red,green,purple"); });
  expect_error(ExitCode::kUsage, {"twice"}, [&] { roles(3, "red,green,red"); });
  expect_error(ExitCode::kUsage, {"no band is left"}, [&] { roles(1, "-"); });
}

TEST_F(Ingest, BandsThatSayOtherwiseAreNotGuessed) {
  const auto roles = [&](std::vector<GDALColorInterp> said) {
    Sketch sketch;
    sketch.bands = int(said.size());
    sketch.creation = {"PHOTOMETRIC=MINISBLACK"};
    sketch.finish = [&](GDALDataset& d) {
      for (size_t i = 0; i < said.size(); ++i) d.GetRasterBand(int(i) + 1)->SetColorInterpretation(said[i]);
    };
    return images({{write("said.tif", sketch)}}).sources()[0].bands;
  };
  using enum BandRole;
  constexpr auto kNothing = GCI_Undefined, kR = GCI_RedBand, kG = GCI_GreenBand, kB = GCI_BlueBand;
  EXPECT_EQ(roles({kNothing, kG, kNothing}), (std::vector{kRed, kGreen, kBlue})) << "as usual";
  EXPECT_EQ(roles({kB, kG, kR}), (std::vector{kRed, kGreen, kBlue}));
  for (const auto& said : std::vector<std::vector<GDALColorInterp>>{
           {kNothing, kG, kR}, {kNothing, kNothing, kR, kNothing}, {kNothing, kR, kG, kB, kNothing}, {kR, kR, kB}})
    expect_error(ExitCode::kBadInput, {"said.tif", "--bands"}, [&] { roles(said); });
}

// Corners that a warp without a mask has filled.
TEST_F(Ingest, BlackCornersThatCountAsGroundAreReported) {
  const auto warnings = [&](int black, bool say_nodata) {
    Sketch sketch;
    sketch.value = [&](int band, int column, int row) {
      const int corner = (column < 32 ? 0 : 1) + (row < 24 ? 0 : 2);
      const bool is_filled = std::min(column, 63 - column) + std::min(row, 47 - row) < 20;
      return is_filled && corner < black ? 0 : 60 + band + column;
    };
    if (say_nodata)
      sketch.finish = [](GDALDataset& d) {
        for (int band = 1; band <= 3; ++band) d.GetRasterBand(band)->SetNoDataValue(0);
      };
    return images({{write("warped.tif", sketch)}}).warnings();
  };
  ASSERT_EQ(warnings(4, false).size(), 1u);
  for (const std::string part : {"warped.tif", "4 of its corners", "--nodata warped.tif=0"})
    EXPECT_NE(warnings(4, false)[0].find(part), std::string::npos) << warnings(4, false)[0];
  EXPECT_EQ(warnings(2, false).size(), 1u);
  EXPECT_TRUE(warnings(1, false).empty()) << "a dark corner is ground";
  EXPECT_TRUE(warnings(4, true).empty());
}

TEST_F(Ingest, NamedBandsComeInTheOrderOfRoles) {
  Sketch sketch;
  sketch.value = [](int band, int, int) { return 10.0 * band; };
  const ImageSet set = images({{write("cir.tif", sketch), "", "nir,red,green", ""}});
  const Stack stack = set.read(pixels_covering(set.bounds(), -1));
  EXPECT_EQ(stack.epochs.at(0).bands.at<cv::Vec3b>(3, 3), cv::Vec3b(20, 30, 10));  // red, green, near infrared
}

// -------------------------------------------------------------------------------------------------------------------

TEST_F(Ingest, NewestFirstAndFirstListedWins) {
  // Five images of constant value; two share a date and overlap by half.
  const auto constant = [&](const std::string& name, double value, double west) {
    Sketch sketch;
    sketch.bands = 1;
    sketch.geotransform[0] = west;
    sketch.value = [value](int, int, int) { return value; };
    return write(name, sketch);
  };
  const std::vector<SourceOptions> files = {{constant("undated.tif", 10, 500'000), "", "", ""},
                                            {constant("first.tif", 20, 500'000), "2009-08-18", "", ""},
                                            {constant("second.tif", 30, 500'016), "2009-08-18", "", ""},
                                            {constant("new.tif", 40, 500'000), "2018-07-16", "", ""},
                                            {constant("elsewhere.tif", 50, 510'000), "2020-01-01", "", ""}};
  const ImageSet set = images(files);
  const Stack stack = set.read(pixels_covering({500'000, 5'199'976, 500'048, 5'200'000}, -1));
  ASSERT_EQ(stack.epochs.size(), 3u);  // nothing of 2020 lies here
  EXPECT_EQ(stack.epochs[0].date, "2018-07-16");
  EXPECT_EQ(stack.epochs[1].date, "2009-08-18");
  EXPECT_EQ(stack.epochs[2].date, "");
  EXPECT_EQ(stack.epochs[1].sources, (std::vector<int>{1, 2}));
  const cv::Mat& both = stack.epochs[1].bands;
  EXPECT_EQ(both.at<uchar>(10, 0), 20);
  EXPECT_EQ(both.at<uchar>(10, 63), 20);  // the overlap goes to the first
  EXPECT_EQ(both.at<uchar>(10, 65), 30);
  EXPECT_EQ(both.at<uchar>(10, 95), 30);
  EXPECT_EQ(stack.epochs[0].valid.at<uchar>(10, 70), 0);  // each epoch has its own gaps
}

TEST_F(Ingest, TilesThatMeetLeaveNoGap) {
  // Four images of another CRS that meet at one corner: inside their union everything is valid.
  std::vector<SourceOptions> files;
  for (int i = 0; i < 4; ++i) {
    Sketch sketch;
    sketch.crs = "EPSG:2056";
    sketch.bands = 1;
    sketch.width = sketch.height = 100;
    const double transform[] = {2'690'000.0 + 50 * (i % 2), 0.5, 0, 1'234'200.0 - 50 * (i / 2), 0, -0.5};
    std::copy(transform, transform + 6, sketch.geotransform);
    files.push_back({write("t" + std::to_string(i) + ".tif", sketch)});
  }
  const ImageSet set = images(files, kZone32);
  double x = 2'690'050, y = 1'234'150;
  transform_point("EPSG:2056", kZone32, x, y);
  const Stack stack = set.read(pixels_covering({x - 40, y - 40, x + 40, y + 40}, -3));
  ASSERT_EQ(stack.epochs.size(), 1u);
  EXPECT_EQ(cv::countNonZero(stack.epochs[0].valid), int(stack.epochs[0].valid.total()));
  EXPECT_EQ(stack.epochs[0].sources.size(), 4u);
}

TEST_F(Ingest, ProvenanceComesFromSidecarAndOptions) {
  const std::string file = write("ortho.tif", {});
  write_text(
      "ortho.tif.json",
      R"({"date": "2016-08-16", "licence": "CC0-1.0", "attribution": "Survey", "georegistration_error_m": 1.5})");
  const ImageSet set = images({{file}});
  const Source& s = set.sources()[0];
  EXPECT_EQ(s.name, "ortho.tif");
  EXPECT_EQ(s.date, "2016-08-16");
  EXPECT_EQ(s.licence, "CC0-1.0");
  EXPECT_EQ(s.attribution, "Survey");
  EXPECT_EQ(s.georegistration_error_m, 1.5);
  EXPECT_EQ(s.crs, "EPSG:32632");
  EXPECT_EQ(images({{file, "2017-01-02", "", ""}}).sources()[0].date, "2017-01-02");
}

TEST_F(Ingest, HashIsThatOfTheFileAndOfWhatAVrtReads) {
  const std::string first = write("a.tif", {});
  std::filesystem::copy_file(first, path("b.tif"));
  Sketch other;
  other.value = [](int, int, int) { return 3.0; };
  EXPECT_EQ(raster_sha256(first).size(), 64u);
  EXPECT_EQ(raster_sha256(first), raster_sha256(path("b.tif")));
  EXPECT_NE(raster_sha256(first), raster_sha256(write("c.tif", other)));
  const auto vrt = [&] {
    const GDALDatasetUniquePtr source(GDALDataset::Open(path("b.tif").c_str()));
    GDALDatasetUniquePtr(GetGDALDriverManager()->GetDriverByName("VRT")->CreateCopy(path("v.vrt").c_str(), source.get(),
                                                                                    0, nullptr, nullptr, nullptr));
    return raster_sha256(path("v.vrt"));
  };
  const std::string before = vrt();
  std::filesystem::copy_file(path("c.tif"), path("b.tif"), std::filesystem::copy_options::overwrite_existing);
  EXPECT_NE(vrt(), before);  // the VRT's own text is the same
  const ImageSet set = images({{path("v.vrt")}});
  EXPECT_EQ(set.read(pixels_covering(set.bounds(), -1)).epochs.at(0).bands.at<cv::Vec3b>(0, 0), cv::Vec3b(3, 3, 3));
}

}  // namespace
}  // namespace landfix::ingest
