#include "builder/ingest/gdal.h"

#include <cpl_error.h>
#include <gdal_priv.h>

#include <mutex>

namespace landfix::ingest {
namespace {

constexpr GIntBig kBlockCacheBytes = 256ll << 20;

void CPL_STDCALL collect(CPLErr severity, CPLErrorNum, const char* message) {
  static_cast<GdalMessages*>(CPLGetErrorHandlerUserData())->add(severity >= CE_Failure, message);
}

}  // namespace

void setup_gdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    GDALAllRegister();
    GDALSetCacheMax64(kBlockCacheBytes);
    CPLSetErrorHandler(CPLQuietErrorHandler);
  });
}

GdalMessages::GdalMessages() { CPLPushErrorHandlerEx(collect, this); }

GdalMessages::~GdalMessages() {
  CPLPopErrorHandler();
  CPLErrorReset();
}

void GdalMessages::add(bool failure, const char* message) {
  failed_ = failed_ || failure;
  if (!text_.empty()) text_ += "; ";
  text_ += message;
}

}  // namespace landfix::ingest
