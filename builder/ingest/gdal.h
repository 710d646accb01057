// GDAL's set-up and errors, in one place.
#pragma once

#include <string>

namespace landfix::ingest {

/// Registers GDAL's drivers, limits its block cache to 256 MiB and silences its messages; once per process, cheap to
/// call again. Everything of this folder calls it; so must code that uses GDAL on its own (export).
void setup_gdal();

/// Collects GDAL's and PROJ's messages of this thread while it lives.
class GdalMessages {
 public:
  GdalMessages();
  ~GdalMessages();
  GdalMessages(const GdalMessages&) = delete;
  GdalMessages& operator=(const GdalMessages&) = delete;

  void add(bool failure, const char* message);
  bool failed() const { return failed_; }            ///< an error (not only warnings) was reported
  const std::string& text() const { return text_; }  ///< joined by "; "

 private:
  bool failed_ = false;
  std::string text_;
};

}  // namespace landfix::ingest
