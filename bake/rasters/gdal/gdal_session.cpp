// SPDX-License-Identifier: MIT
#include "bake/rasters/gdal/gdal_session.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_http.h>
#include <gdal_frmts.h>
#include <ogr_srs_api.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace karst::bake {
namespace {

constexpr std::size_t kMostMessages = 3;
constexpr int kMostHandlers = 1'000;

CPLHTTPResult* fetch_nothing(const char*, CSLConstList, GDALProgressFunc, void*, CPLHTTPFetchWriteFunc, void*,
                             void*) {
  return nullptr;
}

}  // namespace

void prepare_gdal() {
  static bool prepared = false;
  if (std::exchange(prepared, true)) return;
  GDALRegister_GTiff();
  GDALRegister_VRT();
  GDALRegister_PNG();
  GDALRegister_HFA();
  GDALRegister_JP2OpenJPEG();
  GDALRegister_DTED();
  GDALRegister_SRTMHGT();
  GDALRegister_AAIGrid();
  GDALRegister_USGSDEM();
  // Last: they take whatever has a .hdr beside it.
  GDALRegister_EHdr();
  GDALRegister_ENVI();
  CPLSetConfigOption("GDAL_NUM_THREADS", "1");
  CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "TRUE");  // asks for neighbours by name
  CPLSetConfigOption("GDAL_VRT_ENABLE_PYTHON", "NO");
  CPLSetConfigOption("GDAL_PAM_ENABLED", "YES");
  CPLSetConfigOption("GTIFF_REPORT_COMPD_CS", "YES");  // the vertical part of all GeoTIFFs, not of 1.1 alone
  OSRSetPROJEnableNetwork(0);
  CPLHTTPSetFetchCallback(fetch_nothing, nullptr);
}

GdalMessages& GdalMessages::of_process() {
  static GdalMessages messages;
  return messages;
}

void GdalMessages::start(const std::string& name) {
  failures_.clear();
  warnings_.clear();
  names_[0] = name + ": ";
  names_[1] = name.substr(name.find_last_of('/') + 1) + ": ";
  names_[2] = name;
  const auto handler = [](CPLErr kind, CPLErrorNum, const char* text) {
    if (kind == CE_Warning || kind == CE_Failure || kind == CE_Fatal)
      of_process().note(kind == CE_Warning, text);
  };
  CPLSetErrorHandlerEx(handler, this);
  for (int k = 0; k < kMostHandlers && CPLGetErrorHandlerUserData() != this; ++k) CPLPopErrorHandler();
  CPLErrorReset();
}

bool GdalMessages::mentions(std::string_view words) const {
  for (const std::vector<std::string>* list : {&failures_, &warnings_}) {
    for (const std::string& text : *list) {
      if (text.find(words) != std::string::npos) return true;
    }
  }
  return false;
}

void GdalMessages::note(bool is_warning, const char* text) {
  std::vector<std::string>& list = is_warning ? warnings_ : failures_;
  std::string line(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  for (const std::string& name : names_) {
    if (const std::size_t at = line.find(name); at != std::string::npos) line.erase(at, name.size());
  }
  if (list.size() < kMostMessages && std::find(list.begin(), list.end(), line) == list.end())
    list.push_back(std::move(line));
}

std::string plain_name(const std::string& path) {
  return path.starts_with('/') ? "/." + path : "./" + path;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

}  // namespace karst::bake
