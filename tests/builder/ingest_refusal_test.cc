// Ingest: images that are refused, with the words that say what to do.
#include "builder/ingest/image_set.h"
#include "tests/builder/ingest_fixture.h"

namespace landfix::ingest {
namespace {

TEST_F(Ingest, RefusesWhatIsNotPlaced) {
  Sketch nowhere;
  nowhere.geotransform[1] = 0;
  expect_error(ExitCode::kBadInput, {"nowhere.tif", "no georeference", "gdal_translate"},
               [&] { images({{write("nowhere.tif", nowhere)}}); });

  Sketch points = nowhere;
  points.crs = "";
  points.finish = [](GDALDataset& d) {
    GDAL_GCP gcps[3];
    GDALInitGCPs(3, gcps);
    for (int i = 0; i < 3; ++i) {
      gcps[i].dfGCPPixel = gcps[i].dfGCPX = i % 2 * 10;
      gcps[i].dfGCPLine = gcps[i].dfGCPY = i / 2 * 10;
    }
    OGRSpatialReference crs;
    crs.importFromEPSG(32632);
    d.SetGCPs(3, gcps, &crs);
    GDALDeinitGCPs(3, gcps);
  };
  expect_error(ExitCode::kBadInput, {"gcp.tif", "ground control points", "gdalwarp"},
               [&] { images({{write("gcp.tif", points)}}); });

  Sketch turned;
  turned.geotransform[2] = 0.1;
  expect_error(ExitCode::kBadInput, {"turned.tif", "rotated", "gdalwarp"},
               [&] { images({{write("turned.tif", turned)}}); });

  Sketch no_crs;
  no_crs.crs = "";
  expect_error(ExitCode::kBadInput, {"nocrs.tif", "missing", "-a_srs"},
               [&] { images({{write("nocrs.tif", no_crs)}}); });
  Sketch local;
  local.crs = R"(LOCAL_CS["site",UNIT["metre",1]])";
  expect_error(ExitCode::kBadInput, {"local.tif", "unknown or local", "-a_srs"},
               [&] { images({{write("local.tif", local)}}); });

  expect_error(ExitCode::kBadInput, {"far.tif", "zone 59N", "--zone"}, [&] {
    images({{write("far.tif", {})}}, tiles::Zone{59, true});
  });
}

TEST_F(Ingest, RefusesWhatIsNotEightBit) {
  Sketch sketch;
  sketch.bands = 1;
  for (const GDALDataType type : {GDT_UInt16, GDT_Float32}) {
    sketch.type = type;
    expect_error(ExitCode::kBadInput, {"deep.tif", GDALGetDataTypeName(type), "gdal_translate -ot Byte -scale"},
                 [&] { images({{write("deep.tif", sketch)}}); });
  }
  Sketch palette;
  palette.bands = 1;
  palette.finish = [](GDALDataset& d) {
    GDALColorTable table;
    const GDALColorEntry red{255, 0, 0, 255};
    table.SetColorEntry(1, &red);
    d.GetRasterBand(1)->SetColorTable(&table);
  };
  expect_error(ExitCode::kBadInput, {"palette.tif", "palette", "-expand rgb"},
               [&] { images({{write("palette.tif", palette)}}); });
}

TEST_F(Ingest, RefusesWhatIsNoImage) {
  expect_error(ExitCode::kUsage, {"no image"}, [&] { images({}); });
  expect_error(ExitCode::kIo, {"missing.tif", "no such file"}, [&] { images({{path("missing.tif")}}); });
  expect_error(ExitCode::kBadInput, {"text.tif", "not a raster"}, [&] { images({{write_text("text.tif", "hello")}}); });
  const std::string file = write("a.tif", {});
  expect_error(ExitCode::kUsage, {"a.tif", "2009-02-30"}, [&] { images({{file, "2009-02-30", "", ""}}); });
  expect_error(ExitCode::kUsage, {"a.tif", "18.8.2009"}, [&] { images({{file, "18.8.2009", "", ""}}); });
  const auto with_sidecar = [&](const std::string& text, const std::string& word) {
    write_text("a.tif.json", text);
    expect_error(ExitCode::kBadInput, {"a.tif.json", word}, [&] { images({{file}}); });
  };
  with_sidecar("{\"date\": ", "not valid JSON");
  with_sidecar("[1]", "not a JSON object");
  with_sidecar(R"({"datum": 3})", "must be a text");
  with_sidecar(R"({"licence": "x", "colour": "red"})", "unknown key \"colour\"");
  with_sidecar(R"({"date": "2009-13-01"})", "no date");
  with_sidecar(R"({"georegistration_error_m": -1})", "negative");
  with_sidecar(R"({"nodata": "black"})", "must be a number");
}

TEST_F(Ingest, RefusesAbsurdWindows) {
  const ImageSet set = images({{write("a.tif", {})}});
  expect_error(ExitCode::kInternal, {"cannot be read at once"}, [&] {
    set.read(tiles::PixelRect{-1, 0, 0, 100'000, 100'000});
  });
  expect_error(ExitCode::kInternal, {"cannot be read at once"}, [&] { set.read(tiles::PixelRect{-1, 0, 0, 0, 5}); });
  expect_error(ExitCode::kBadInput, {"2^31", "coarser"}, [&] { pixels_covering({0, 0, 1e7, 1e7}, -10); });
  expect_error(ExitCode::kBadInput, {"empty"}, [&] { pixels_covering({5, 5, 5, 6}, 0); });
}

}  // namespace
}  // namespace landfix::ingest
