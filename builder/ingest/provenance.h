// Sidecars: what people say about a file that the file itself does not.
#pragma once

#include <optional>
#include <string>

namespace landfix::ingest {

/// Contents of `FILE.json` beside FILE; members that it does not have are empty.
struct Sidecar {
  std::string date;  ///< "2009-08-18"
  std::string licence;
  std::string attribution;
  std::string bands;             ///< as SourceOptions::bands
  std::string datum;             ///< as SourceOptions::datum
  std::optional<double> nodata;  ///< as SourceOptions::nodata
  std::optional<double> georegistration_error_m;
};

/// Reads `path` + ".json"; an empty Sidecar where there is none. Throws Error (kBadInput) for what is not JSON, not an
/// object, has an unknown key, a value of the wrong type, a date that is no date or a negative error.
Sidecar read_sidecar(const std::string& path);

/// Whether `text` is a day of the calendar as "2009-08-18".
bool is_date(const std::string& text);

}  // namespace landfix::ingest
