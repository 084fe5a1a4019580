// SPDX-License-Identifier: MIT
// The tables of docs/devices.md, made of what karst-device wrote on each device.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "platform/base/error.h"

namespace karst::device {

struct DeviceReport {
  std::string name;  // of the device in the tables: the file's name without .json
  nlohmann::ordered_json json;
};

// Reads files of run_session(). The error names the file and what it lacks.
Error read_reports(const std::vector<std::string>& files, std::vector<DeviceReport>& reports);

// Markdown: what was run, frame times, pictures, what the drivers can do.
std::string device_tables(const std::vector<DeviceReport>& reports);

// The page with the tables between its lines kTablesBegin and kTablesEnd replaced. The error says that it has
// no such lines.
inline constexpr const char* kTablesBegin = "<!-- made by ./dev devices -->";
inline constexpr const char* kTablesEnd = "<!-- end -->";
Error replace_tables(const std::string& tables, std::string& page);

}  // namespace karst::device
