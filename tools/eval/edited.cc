#include "tools/eval/edited.h"

#include <exiv2/exiv2.hpp>

#include "builder/error.h"

namespace landfix::eval {

bool edited_since_capture(const std::string& path) {
  try {
    const auto file = Exiv2::ImageFactory::open(path);
    file->readMetadata();
    const Exiv2::ExifData& exif = file->exifData();
    const auto written = exif.findKey(Exiv2::ExifKey("Exif.Image.DateTime")),
               taken = exif.findKey(Exiv2::ExifKey("Exif.Photo.DateTimeOriginal"));
    // "2016:06:23 19:24:42": the order of the texts is that of the times.
    return written != exif.end() && taken != exif.end() && written->toString() > taken->toString();
  } catch (const std::exception& e) {
    throw Error(ExitCode::kBadInput, path + ": the metadata cannot be read: " + e.what());
  }
}

}  // namespace landfix::eval
