// SPDX-License-Identifier: MIT
// GDAL in a process that reads files which nobody can trust: drivers of a list that is stated here and no
// other, no net, no code, one thread; and what GDAL says of a file.
#pragma once

#include <gdal.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace karst::bake {

// GDAL reads what these drivers read, from files, by one thread. Once a process.
void prepare_gdal();

// What GDAL says of a file. One for the process: drivers that fail can leave handlers behind that they have
// pushed over ours.
class GdalMessages {
 public:
  static GdalMessages& of_process();

  // name: of the file, as GDAL gets it. What messages say of it is left out.
  void start(const std::string& name);

  const std::vector<std::string>& failures() const { return failures_; }
  const std::vector<std::string>& warnings() const { return warnings_; }
  bool mentions(std::string_view words) const;

 private:
  void note(bool is_warning, const char* text);

  std::string names_[3];
  std::vector<std::string> failures_, warnings_;
};

struct CloseGdalFile {
  void operator()(void* file) const { GDALClose(file); }
};
using GdalFile = std::unique_ptr<void, CloseGdalFile>;

// A name that GDAL takes for that of a file, whatever it is.
std::string plain_name(const std::string& path);

// Nine digits at most.
std::string short_number(double value);

}  // namespace karst::bake
