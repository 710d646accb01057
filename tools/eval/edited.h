// Whether a photograph still is as the camera wrote it.
#pragma once

#include <string>

namespace landfix::eval {

/// Whether EXIF says that a program wrote the file again after it was taken (DateTime later than DateTimeOriginal): it
/// may have turned the picture, and the attitude in the tags then belongs to another picture. False where the tags do
/// not say. Throws Error(kBadInput) where the metadata cannot be read.
bool edited_since_capture(const std::string& path);

}  // namespace landfix::eval
