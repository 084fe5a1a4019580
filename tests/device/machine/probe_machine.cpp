// SPDX-License-Identifier: MIT
#include <sys/utsname.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "tests/device/machine/probe.h"
#include "tests/support/process.h"

namespace karst::device {
namespace {

// The value of the first "name ... = value" or "name ... : value" line of a file; empty where there is none.
std::string value_in(const std::string& path, const std::string& name) {
  std::istringstream text(test::read_text(path));
  for (std::string line; std::getline(text, line);) {
    const std::size_t separator = line.find_first_of("=:");
    if (!line.starts_with(name) || separator == std::string::npos) continue;
    const std::size_t begin = line.find_first_not_of(" \t\"", separator + 1);
    if (begin == std::string::npos) return "";
    return line.substr(begin, line.find_last_not_of(" \t\"") + 1 - begin);
  }
  return "";
}

// A file of one line, without what ends it.
std::string line_of(const std::string& path) {
  const std::string text = test::read_text(path);
  return text.substr(0, text.find_last_not_of(std::string_view("\0\n ", 3)) + 1);
}

}  // namespace

Json probe_machine() {
  utsname system{};
  uname(&system);
  std::string model = line_of("/proc/device-tree/model");
  if (model.empty()) model = line_of("/sys/class/dmi/id/product_name");
  double load[1] = {-1};
  getloadavg(load, 1);
  const std::int64_t memory_bytes = std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE);
  std::string processor = value_in("/proc/cpuinfo", "model name");
  if (processor.empty()) processor = value_in("/proc/cpuinfo", "Hardware");
  return {{"model", model},
          {"processor", processor},
          {"cores", sysconf(_SC_NPROCESSORS_ONLN)},
          {"memory_mib", memory_bytes >> 20},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.machine},
          {"distribution", value_in("/etc/os-release", "PRETTY_NAME")},
          {"load", load[0]}};
}

}  // namespace karst::device
