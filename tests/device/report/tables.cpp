// SPDX-License-Identifier: MIT
#include "tests/device/report/tables.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <filesystem>

#include "tests/support/process.h"

namespace karst::device {
namespace {

using Json = nlohmann::ordered_json;

__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...) {
  char buffer[1024];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  text += buffer;
}

// A value below keys; null where there is none.
Json at(const Json& json, std::initializer_list<const char*> keys) {
  const Json* value = &json;
  for (const char* key : keys) {
    if (!value->is_object() || !value->contains(key)) return nullptr;
    value = &(*value)[key];
  }
  return *value;
}

std::string text_at(const Json& json, std::initializer_list<const char*> keys) {
  const Json value = at(json, keys);
  std::string text = value.is_string() ? value.get<std::string>() : value.is_null() ? "" : value.dump();
  std::replace(text.begin(), text.end(), '|', '/');
  return text;
}

// "12.3"; a dash where there is no number.
std::string number_at(const Json& json, std::initializer_list<const char*> keys, int digits,
                      double divisor = 1) {
  const Json value = at(json, keys);
  if (!value.is_number()) return "–";
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", digits, value.get<double>() / divisor);
  return text;
}

std::size_t size_at(const Json& json, const char* key) {
  const Json value = at(json, {key});
  return value.is_array() ? value.size() : 0;
}

struct PictureSums {
  int same = 0, close = 0, different = 0;
  double mean = 0, most = 0;  // the largest of all
};

PictureSums sums_of(const Json& pictures) {
  PictureSums sums;
  for (const Json& picture : pictures) {
    const std::string result = text_at(picture, {"result"});
    ++(result == "same" ? sums.same : result == "close" ? sums.close : sums.different);
    sums.mean = std::max(sums.mean, picture.value("mean", 0.0));
    sums.most = std::max(sums.most, picture.value("max", 0.0));
  }
  return sums;
}

std::string runs_table(const std::vector<DeviceReport>& reports) {
  std::string text =
      "| device | GL | machine | date, karst | tests passed, failed, skipped | pictures the same, close, "
      "different | largest mean, maximum of 255 |\n|---|---|---|---|---|---|---|\n";
  for (const DeviceReport& report : reports) {
    const Json& json = report.json;
    std::size_t passed = 0, failed = 0, skipped = 0;
    for (const Json& suite : at(json, {"tests"})) {
      passed += size_at(suite, "passed");
      failed += size_at(suite, "failed") + size_at(suite, "not_run");
      skipped += size_at(suite, "skipped");
    }
    const PictureSums sums = sums_of(at(json, {"pictures"}));
    text += "| " + report.name + " | " + text_at(json, {"device", "gl", "renderer"}) + "; " +
            text_at(json, {"device", "gl", "version"});
    text += " | " + text_at(json, {"machine", "processor"}) + ", " + text_at(json, {"machine", "cores"}) +
            " cores | " + text_at(json, {"date"}).substr(0, 10) + ", " + text_at(json, {"karst", "commit"});
    append(text, " | %zu, %zu, %zu | %d, %d, %d | %.3f, %.0f |\n", passed, failed, skipped, sums.same,
           sums.close, sums.different, sums.mean, sums.most);
  }
  return text;
}

std::string frames_table(const std::vector<DeviceReport>& reports) {
  std::string text =
      "| device | way | flight | frames | frame ms: median | p95 | GPU ms: median | p95 | CPU ms, all "
      "threads | "
      "triangles | GPU memory, MiB |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const DeviceReport& report : reports) {
    for (const Json& way : at(report.json, {"frames"})) {
      for (const Json& flight : at(way, {"flights"})) {
        text += "| " + report.name + " | " + text_at(way, {"way"}) + " | " + text_at(flight, {"name"}) +
                " | " + number_at(way, {"frames"}, 0);
        for (const char* time : {"frame_ms", "gpu_ms"})
          text +=
              " | " + number_at(flight, {time, "median"}, 1) + " | " + number_at(flight, {time, "p95"}, 1);
        text += " | " + number_at(flight, {"cpu_ms", "median"}, 1) + " | " +
                number_at(flight, {"triangles"}, 0) + " | " +
                number_at(way, {"bytes", "gpu_used"}, 1, 1 << 20) + " |\n";
      }
    }
  }
  return text;
}

// A column a device. value: of a report, for row n.
template <class Value>
void add_row(const std::string& title, const std::vector<DeviceReport>& reports, Value value,
             std::string& text) {
  text += "| " + title + " |";
  for (const DeviceReport& report : reports) text.append(" ").append(value(report.json)).append(" |");
  text += "\n";
}

void add_head(const std::string& title, const std::vector<DeviceReport>& reports, std::string& text) {
  text += "| " + title + " |";
  for (const DeviceReport& report : reports) text += " " + report.name + " |";
  text += "\n|---|";
  for (std::size_t n = 0; n < reports.size(); ++n) text += "---|";
  text += "\n";
}

// Names in all reports, each once, in the order in which they come.
template <class Names>
std::vector<std::string> all_names(const std::vector<DeviceReport>& reports, Names names) {
  std::vector<std::string> all;
  for (const DeviceReport& report : reports) {
    for (const std::string& name : names(report.json)) {
      if (std::find(all.begin(), all.end(), name) == all.end()) all.push_back(name);
    }
  }
  return all;
}

std::string pictures_table(const std::vector<DeviceReport>& reports) {
  std::string text;
  add_head("picture: mean, maximum of 255", reports, text);
  const auto names = all_names(reports, [](const Json& json) {
    std::vector<std::string> found;
    for (const Json& picture : at(json, {"pictures"})) found.push_back(text_at(picture, {"name"}));
    return found;
  });
  for (const std::string& name : names) {
    add_row(
        name, reports,
        [&](const Json& json) {
          for (const Json& picture : at(json, {"pictures"})) {
            if (text_at(picture, {"name"}) != name) continue;
            if (!picture.contains("mean")) return text_at(picture, {"result"});
            return number_at(picture, {"mean"}, 3) + ", " + number_at(picture, {"max"}, 0);
          }
          return std::string("–");
        },
        text);
  }
  return text;
}

std::string abilities_table(const std::vector<DeviceReport>& reports) {
  std::string text;
  add_head("limits and extensions", reports, text);
  for (const char* group : {"limits", "mantissa_bits", "extensions"}) {
    const auto names = all_names(reports, [&](const Json& json) {
      std::vector<std::string> found;
      const Json values = at(json, {"device", group});
      for (const auto& [name, value] : values.items()) found.push_back(name);
      return found;
    });
    for (const std::string& name : names) {
      add_row(
          "`" + name + "`", reports,
          [&](const Json& json) {
            const Json value = at(json, {"device", group, name.c_str()});
            if (value.is_boolean()) return std::string(value.get<bool>() ? "yes" : "no");
            return value.is_null() ? std::string("–") : value.dump();
          },
          text);
    }
  }
  return text;
}

}  // namespace

Error read_reports(const std::vector<std::string>& files, std::vector<DeviceReport>& reports) {
  for (const std::string& file : files) {
    DeviceReport report;
    report.name = std::filesystem::path(file).stem().string();
    report.json = Json::parse(test::read_text(file), nullptr, false);
    if (!report.json.is_object()) return file + ": is not there or no JSON";
    for (const char* key : {"format", "date", "machine", "tests", "pictures", "frames"}) {
      if (!report.json.contains(key)) return file + ": has no '" + key + "', so run did not write it";
    }
    reports.push_back(std::move(report));
  }
  return {};
}

std::string device_tables(const std::vector<DeviceReport>& reports) {
  return runs_table(reports) + "\n" + frames_table(reports) + "\n" + pictures_table(reports) + "\n" +
         abilities_table(reports);
}

Error replace_tables(const std::string& tables, std::string& page) {
  const std::string begin_line = std::string(kTablesBegin) + "\n";
  const std::size_t begin = page.find(begin_line);
  const std::size_t end = page.find(kTablesEnd);
  if (begin == std::string::npos || end == std::string::npos || end < begin)
    return std::string("has no lines '") + kTablesBegin + "' and '" + kTablesEnd + "'";
  const std::size_t after = begin + begin_line.size();
  page.replace(after, end - after, "\n" + tables + "\n");
  return {};
}

}  // namespace karst::device
