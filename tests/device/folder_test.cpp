// SPDX-License-Identifier: MIT
// The folder that `./dev gpu` makes does its work where nothing else of karst is: it is unpacked elsewhere,
// and the sources and the build are hidden from it where the machine allows that.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"

namespace karst::device {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::ProcessResult;
using Words = std::vector<std::string>;

constexpr const char* kFolder = KARST_SOURCE_DIR "/tests/device/folder";

class DeviceFolder : public testing::Test {
 protected:
  void SetUp() override {
    if (KARST_DEVICE_FOLDER == 0) GTEST_SKIP() << "only release builds make it";
    Words words = {KARST_BUILD_DIR, KARST_BUILD_DIR, scratch_.path("made"), KARST_BUILD_DIR "/tests/worlds"};
    if (plan() == "quick") words.insert(words.end(), {"canyon", "caves"});
    const ProcessResult made = test::run_process(std::string(kFolder) + "/make.sh", words);
    ASSERT_EQ(made.code, 0) << made.err;
    fs::remove_all(scratch_.path("made"));
    const ProcessResult unpacked =
        test::run_process("/bin/tar", {"-xzf", scratch_.path("made.tar.gz"), "-C", scratch_.path("")});
    ASSERT_EQ(unpacked.code, 0) << unpacked.err;
    fs::rename(scratch_.path("made"), scratch_.path("elsewhere"));
    hides_ = test::run_process("/usr/bin/unshare", {"-rm", "mount", "-t", "tmpfs", "none", KARST_SOURCE_DIR})
                 .code == 0;
    // All commands that a device must have.
    fs::create_directory(scratch_.path("commands"));
    for (const char* command : {"cat", "dirname", "uname"})
      fs::create_symlink(std::string("/usr/bin/") + command,
                         scratch_.path(std::string("commands/") + command));
  }

  static std::string plan() {
    const char* const name = std::getenv("KARST_DEVICE_PLAN");
    return name == nullptr ? "quick" : name;
  }
  std::string at(const std::string& name) const { return scratch_.path("elsewhere/" + name); }

  // ./run with words, from another folder.
  ProcessResult run(const Words& words) const {
    Words all = {at("run")};
    if (hides_) {
      const std::string hide = "mount -t tmpfs none '" KARST_SOURCE_DIR
                               "' && mount -t tmpfs none '" KARST_DATA_DIR "' 2>/dev/null; PATH='" +
                               scratch_.path("commands") + "' exec \"$@\"";
      all = {"/usr/bin/unshare", "-rm", "/bin/sh", "-c", hide, "sh", at("run")};
    }
    all.insert(all.end(), words.begin(), words.end());
    return test::run_process(all[0], Words(all.begin() + 1, all.end()));
  }
  static json result(const std::string& path) { return json::parse(test::read_text(path), nullptr, false); }

  void check_all_but_one_picture();
  void check_that_others_go_on();
  void check_usage();

  test::Folder scratch_;
  bool hides_ = false;
};

void DeviceFolder::check_all_but_one_picture() {
  const std::string wrong = at("pictures/canyon.png");
  fs::copy_file(wrong, scratch_.path("right.png"));
  fs::copy_file(at("pictures/caves.png"), wrong, fs::copy_options::overwrite_existing);
  const std::string file = scratch_.path("a.json");
  const ProcessResult ran = run({"--plan", plan(), "-o", file, "--keep", scratch_.path("kept")});
  fs::copy_file(scratch_.path("right.png"), wrong, fs::copy_options::overwrite_existing);
  EXPECT_EQ(ran.code, 1) << ran.err;
  std::printf("%s%s", hides_ ? "sources and build were hidden\n" : "", ran.err.c_str());

  const json a = result(file);
  ASSERT_TRUE(a.is_object());
  EXPECT_EQ(a["complete"], true);
  EXPECT_EQ(a["plan"], plan());
  EXPECT_FALSE(a["karst"]["commit"].get<std::string>().empty());
  EXPECT_EQ(a["date"].get<std::string>().size(), 20u);
  EXPECT_GT(a["machine"]["memory_mib"], 0);
  for (const char* text : {"vendor", "renderer", "version", "shading_language"})
    EXPECT_FALSE(a["device"]["gl"][text].get<std::string>().empty()) << text;
  EXPECT_GE(a["device"]["limits"]["max_texture_size"], 2048);
  EXPECT_TRUE(a["device"]["extensions"]["GL_EXT_disjoint_timer_query"].is_boolean());

  for (const char* suite : {"gl", "library", "golden"}) {
    const json& tests = a["tests"][suite];
    EXPECT_GE(tests["passed"].size(), 1u) << suite;
    // In the full plan the golden tests look at the wrong picture too.
    const bool sees_it = plan() != "quick" && std::string(suite) == "golden";
    EXPECT_EQ(tests["failed"].size(), sees_it ? 1u : 0u) << suite << tests["failed"];
    EXPECT_EQ(tests["not_run"].size(), 0u) << suite;
    EXPECT_EQ(tests["problem"], "") << suite;
  }
  for (const json& picture : a["pictures"]) {
    const bool is_wrong = picture["name"] == "canyon";
    EXPECT_EQ(picture["result"] == "different", is_wrong) << picture;
    EXPECT_EQ(picture["mean"] > 10, is_wrong) << picture;
    EXPECT_EQ(picture["max"] > 100, is_wrong) << picture;
  }
  EXPECT_GE(a["pictures"].size(), 2u);
  EXPECT_TRUE(fs::exists(scratch_.path("kept/canyon.png")));

  ASSERT_GE(a["frames"].size(), 1u);
  for (const json& way : a["frames"]) {
    EXPECT_GT(way["bytes"]["gpu_used"], 100'000);
    EXPECT_GT(way["bytes"]["process_peak"], 1'000'000);
    ASSERT_EQ(way["flights"].size(), 3u);
    for (const json& flight : way["flights"]) {
      EXPECT_GT(flight["frame_ms"]["median"], 0);
      EXPECT_GE(flight["frame_ms"]["p95"], flight["frame_ms"]["median"]);
      EXPECT_EQ(flight["gpu_ms"].is_object(),
                a["device"]["extensions"]["GL_EXT_disjoint_timer_query"].get<bool>());
    }
  }
  EXPECT_GT(a["programs"].at(0)["output"].size(), 3u);
  EXPECT_EQ(a["failures"].size(), plan() == "quick" ? 1u : 2u) << a["failures"];
}

// Parts that fail do not stop the others.
void DeviceFolder::check_that_others_go_on() {
  const std::string plan =
      scratch_.write("own.plan", std::string("program gone : no_such_program\n"
                                             "frames bad : canyon --no-such-option\n"
                                             "frames none : no_such_world\n"
                                             "pictures none : no_such_picture\n"
                                             "tests none : karst_gl_tests --gtest_filter=No.*\n"
                                             "pictures hall : caves_hall\n"));
  const std::string file = scratch_.path("b.json");
  EXPECT_EQ(run({"--plan", plan, "-o", file}).code, 1);
  const json b = result(file);
  ASSERT_TRUE(b.is_object());
  EXPECT_EQ(b["complete"], true);
  EXPECT_EQ(b["failures"].size(), 5u) << b["failures"];
  ASSERT_EQ(b["pictures"].size(), 1u);
  EXPECT_NE(b["pictures"][0]["result"], "different");
  EXPECT_NE(b["failures"].dump().find("--no-such-option"), std::string::npos) << b["failures"];
  EXPECT_EQ(test::read_text(file).find(scratch_.path("elsewhere")), std::string::npos);

  EXPECT_EQ(run({"--plan", plan, "--only", "pictures", "-o", file}).code, 1);
  EXPECT_EQ(result(file)["failures"].size(), 1u);
}

void DeviceFolder::check_usage() {
  const ProcessResult help = run({"--help"});
  EXPECT_EQ(help.code, 0) << help.err;
  EXPECT_NE(help.out.find("./run --quick"), std::string::npos);
  EXPECT_EQ(run({"--no-such-option"}).code, 2);
  EXPECT_EQ(run({"--plan", "none"}).code, 2);
  EXPECT_EQ(run({"--only", "none"}).code, 2);
  EXPECT_EQ(run({"-o"}).code, 2);
  EXPECT_EQ(run({"-o", scratch_.path("no/folder.json")}).code, 1);
  const ProcessResult list = run({"--list"});
  EXPECT_NE(list.out.find("canyon_fine"), std::string::npos) << list.out;

  // On another processor it says so instead of failing to start.
  scratch_.write("elsewhere/machine", std::string("m68k\n"));
  const ProcessResult other = run({"--help"});
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.err.find("m68k"), std::string::npos) << other.err;
}

TEST_F(DeviceFolder, WorksElsewhere) {
  check_all_but_one_picture();
  check_that_others_go_on();
  check_usage();
}

}  // namespace
}  // namespace karst::device
