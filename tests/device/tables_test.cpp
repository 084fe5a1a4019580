// SPDX-License-Identifier: MIT
#include "tests/device/report/tables.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace karst::device {
namespace {

constexpr const char* kReport = R"({
  "format": 1, "karst": {"version": "0.2.0", "commit": "abc1234"}, "date": "2026-01-02T03:04:05Z",
  "machine": {"processor": "Some | CPU", "cores": 4},
  "device": {"gl": {"renderer": "Some GPU", "version": "OpenGL ES 3.0"},
             "limits": {"max_texture_size": 4096}, "extensions": {"GL_KHR_debug": true}},
  "tests": {"gl": {"passed": ["A.a", "A.b"], "failed": [{"name": "A.c"}], "skipped": [], "not_run": ["A.d"]}},
  "pictures": [{"name": "canyon", "result": "close", "mean": 0.25, "max": 12},
               {"name": "caves", "result": "not drawn"}],
  "frames": [{"way": "default", "frames": 12, "bytes": {"gpu_used": 10485760},
              "flights": [{"name": "low", "frame_ms": {"median": 12.34, "p95": 20}, "gpu_ms": null,
                           "cpu_ms": {"median": 5}, "triangles": 1000.4}]}]
})";

TEST(Tables, SayWhatWasMeasuredAndWhatWasNot) {
  const std::vector<DeviceReport> reports = {{"board", nlohmann::ordered_json::parse(kReport)}};
  const std::string text = device_tables(reports);
  for (const char* line :
       {"| board | Some GPU; OpenGL ES 3.0 | Some / CPU, 4 cores | 2026-01-02, abc1234 | 2, 2, 0 | 0, 1, 1 | "
        "0.250, 12 |\n",
        "| board | default | low | 12 | 12.3 | 20.0 | – | – | 5.0 | 1000 | 10.0 |\n",
        "| canyon | 0.250, 12 |\n", "| caves | not drawn |\n", "| `max_texture_size` | 4096 |\n",
        "| `GL_KHR_debug` | yes |\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "is not in\n" << text;
  }
}

TEST(Tables, DevicesThatLackSomethingHaveADash) {
  std::vector<DeviceReport> reports(2, {"a", nlohmann::ordered_json::parse(kReport)});
  reports[1].json["device"] = nullptr;
  reports[1].json["pictures"].clear();
  const std::string text = device_tables(reports);
  EXPECT_NE(text.find("| canyon | 0.250, 12 | – |\n"), std::string::npos) << text;
  EXPECT_NE(text.find("| `GL_KHR_debug` | yes | – |\n"), std::string::npos) << text;
}

TEST(Tables, RefusesOtherFiles) {
  const test::Folder folder;
  std::vector<DeviceReport> reports;
  EXPECT_FALSE(read_reports({folder.path("none.json")}, reports).ok());
  EXPECT_FALSE(read_reports({folder.write("a.json", std::string("{\"format\": 1}"))}, reports).ok());
  EXPECT_FALSE(read_reports({folder.write("a.json", std::string("[1"))}, reports).ok());
  const Error error = read_reports({folder.write("b.json", std::string(kReport))}, reports);
  ASSERT_TRUE(error.ok()) << error.text();
  EXPECT_EQ(reports.at(0).name, "b");
}

TEST(Tables, TakeTheirPlaceInThePage) {
  std::string page = std::string("before\n") + kTablesBegin + "\nold\n" + kTablesEnd + "\nafter\n";
  ASSERT_TRUE(replace_tables("| new |\n", page).ok());
  EXPECT_EQ(page, std::string("before\n") + kTablesBegin + "\n\n| new |\n\n" + kTablesEnd + "\nafter\n");
  std::string other = "no lines\n";
  EXPECT_FALSE(replace_tables("x", other).ok());
  EXPECT_EQ(other, "no lines\n");
}

TEST(Tables, ThePageIsMadeOfTheFilesBesideIt) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(KARST_SOURCE_DIR "/docs/devices"))
    files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  std::vector<DeviceReport> reports;
  const Error error = read_reports(files, reports);
  ASSERT_TRUE(error.ok()) << error.text();
  const std::string page = test::read_text(KARST_SOURCE_DIR "/docs/devices.md");
  std::string made = page;
  ASSERT_TRUE(replace_tables(device_tables(reports), made).ok());
  EXPECT_EQ(page, made) << "run ./dev devices";
}

}  // namespace
}  // namespace karst::device
