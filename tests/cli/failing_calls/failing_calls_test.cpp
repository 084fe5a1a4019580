// SPDX-License-Identifier: MIT
// What programs do where one call of theirs fails (failing_calls.cpp): the old file or the new one, one
// line, no hang, nothing left behind. A sample of all calls; every one with KARST_ALL_CALLS=1 (label long).
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using Words = std::vector<std::string>;

constexpr int kTimedOut = 124;  // of timeout(1)

struct Job {
  const char* name;
  std::string program;
  Words words;         // OUT, WORLD, DEM and GROUND, a world of it, stand for files
  bool bytes_are_set;  // what it writes is the same every time
};

const Job kJobs[] = {{"bake",
                      KARST_BAKE_PATH,
                      {"--sample", "hills", "--no-ground", "-o", "OUT", "--voxel", "400", "--levels", "1",
                       "--materials", "none", "--quiet", "--threads", "2"},
                      true},
                     {"bake_ground",
                      KARST_BAKE_PATH,
                      {"DEM", "-o", "OUT", "--ground", "--pixel-size", "10", "--materials", "none", "--quiet",
                       "--threads", "2"},
                      true},
                     {"render_ground",
                      KARST_APP_PATH,
                      {"render", "GROUND", "-o", "OUT", "--size", "32x24", "--camera", "0,~3,0,0,-5"},
                      true},
                     {"view_ground",
                      KARST_APP_PATH,
                      {"view", "GROUND", "--headless", "--frames", "2", "--size", "32x24", "--stats", "OUT"},
                      false},
                     {"render", KARST_APP_PATH, {"render", "WORLD", "-o", "OUT", "--size", "32x24"}, true},
                     {"view",
                      KARST_APP_PATH,
                      {"view", "WORLD", "--headless", "--frames", "2", "--size", "32x24", "--stats", "OUT"},
                      false}};

class FailingCalls : public testing::TestWithParam<Job> {
 protected:
  void SetUp() override {
    test::TestWorld world = test::TestWorld::hills();
    world.roughen(2, 9, 500);
    world_ = inputs_.write("world.karst", world.file());
    std::vector<std::int16_t> samples;
    for (int k = 0; k < 150 * 150; ++k) samples.push_back(static_cast<std::int16_t>(k % 150 + k % 7));
    dem_ = inputs_.write("dem.bil", std::as_bytes(std::span(samples)));
    inputs_.write("dem.hdr",
                  std::string("ncols 150\nnrows 150\nnbits 16\npixeltype signedint\nbyteorder I\n"));
    ground_ = inputs_.path("ground.karst");
    const Words words = {dem_, "-o",          ground_, "--ground", "--pixel-size",
                         "10", "--materials", "none",  "--quiet"};
    ASSERT_EQ(test::run_process(KARST_BAKE_PATH, words).code, 0);
  }

  // Fails call number `at`; the count of them goes to count_.
  test::ProcessResult run(const std::string& call, std::uint64_t at) const {
    const Job& job = GetParam();
    Words words = {"60",
                   "env",
                   std::string("LD_PRELOAD=") + KARST_FAILING_CALLS_PATH,
                   "KARST_FAIL_CALL=" + call,
                   "KARST_FAIL_AT=" + std::to_string(at),
                   "KARST_FAIL_COUNT=" + inputs_.path("count"),
                   job.program};
    for (const std::string& word : job.words)
      words.push_back(word == "OUT"      ? out()
                      : word == "WORLD"  ? world_
                      : word == "DEM"    ? dem_
                      : word == "GROUND" ? ground_
                                         : word);
    return test::run_process("/usr/bin/timeout", words);
  }
  std::string out() const { return outputs_.path("out"); }
  std::uint64_t counted() const {
    return std::strtoull(test::read_text(inputs_.path("count")).c_str(), nullptr, 10);
  }

  // Where nothing can be told apart from a run without failures, code must be 0.
  void expect_old_or_new(const test::ProcessResult& result, const std::string& made) {
    const std::string now = test::read_text(out());
    EXPECT_NE(result.code, kTimedOut) << "it hangs";
    EXPECT_TRUE(result.code == 0 || result.code == 1) << result.code << " " << result.err;
    const bool is_new = GetParam().bytes_are_set ? now == made : now.starts_with("{") && now.ends_with("}\n");
    EXPECT_TRUE(now == "old" || is_new) << "torn: " << now.size() << " bytes";
    EXPECT_TRUE(is_new || result.code != 0) << "it says that all is well: " << result.err;
    if (result.code == 1) {
      EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
      EXPECT_EQ(result.err.rfind("karst", 0), 0u) << result.err;
    }
    EXPECT_EQ(outputs_.names(), Words{"out"}) << "something was left behind";
  }

  test::Folder inputs_, outputs_;
  std::string world_, dem_, ground_;
};

// The first ones and some of the others.
std::set<std::uint64_t> chosen(std::uint64_t count) {
  const bool all = std::getenv("KARST_ALL_CALLS") != nullptr;
  std::set<std::uint64_t> result;
  for (std::uint64_t n = 1; n <= count && (all || n <= 2); ++n) result.insert(n);
  for (std::uint64_t k = 0; !all && count > 0 && k < 4; ++k) result.insert(1 + (count - 1) * k / 3);
  return result;
}

TEST_P(FailingCalls, LeaveTheOldFileOrTheNewOne) {
  for (const char* call : {"open", "read", "write", "fsync", "rename", "malloc"}) {
    outputs_.write("out", std::string("old"));
    const test::ProcessResult whole = run(call, 0);
    ASSERT_EQ(whole.code, 0) << whole.err;
    const std::string made = test::read_text(out());
    const std::uint64_t count = counted();
    std::printf("%s: %llu calls of %s\n", GetParam().name, static_cast<unsigned long long>(count), call);
    // bake of a sample reads nothing, and of a DEM by its children alone.
    const bool reads = GetParam().program != KARST_BAKE_PATH;
    ASSERT_TRUE(count > 0 || (!reads && std::string_view(call) == "read")) << call;
    for (const std::uint64_t at : chosen(count)) {
      outputs_.write("out", std::string("old"));
      SCOPED_TRACE(std::string(call) + " " + std::to_string(at));
      expect_old_or_new(run(call, at), made);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OfEveryProgram, FailingCalls, testing::ValuesIn(kJobs),
                         [](const auto& one) { return std::string(one.param.name); });

// With exit code 0 and the same bytes.
class FailingThreads : public FailingCalls {};
TEST_P(FailingThreads, EndInFewerThreads) {
  outputs_.write("out", std::string("old"));
  ASSERT_EQ(run("thread", 0).code, 0);
  const std::string made = test::read_text(out());
  const std::uint64_t count = counted();
  ASSERT_GT(count, 0u) << "the job must make threads";
  for (const std::uint64_t at : chosen(count)) {
    outputs_.write("out", std::string("old"));
    const test::ProcessResult result = run("thread", at);
    EXPECT_EQ(result.code, 0) << at << " " << result.err;
    EXPECT_TRUE(test::read_text(out()) == made) << at;
  }
}
INSTANTIATE_TEST_SUITE_P(OfBake, FailingThreads, testing::Values(kJobs[0], kJobs[1]),
                         [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace karst::core
