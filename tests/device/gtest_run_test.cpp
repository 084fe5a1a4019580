// SPDX-License-Identifier: MIT
// Programs that misbehave like drivers do, told by shell scripts that print what GoogleTest prints.
#include "tests/device/run/gtest_run.h"

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace karst::device {
namespace {

using Names = std::vector<std::string>;

// Knows the tests A.one, A.two, P/B.three/0 and P/B.three/1; runs those of --gtest_filter.
constexpr const char* kProgram = R"sh(#!/bin/sh
filter=
for word; do
  case $word in
    --gtest_list_tests)
      echo 'Running main() from gtest_main.cc'
      echo 'A.'; echo '  one'; echo '  two'; echo '  DISABLED_never'
      echo 'P/B.'; echo '  three/0  # GetParam() = 4'; echo '  three/1  # GetParam() = 5'
      exit 0 ;;
    --gtest_filter=*) filter=${word#--gtest_filter=} ;;
  esac
done
before_all
run() {
  case ":$filter:" in *":$1:"*) ;; *) return ;; esac
  echo "[ RUN      ] $1"
  case $1 in
    A.two) two ;;
    *) echo "[       OK ] $1 (3 ms)" ;;
  esac
}
run A.one; run A.two; run P/B.three/0; run P/B.three/1
echo '[==========] all of them'
after_all
)sh";

class GtestRun : public testing::Test {
 protected:
  // The program with these bodies of its three functions.
  GtestResult run(const std::string& two, const std::string& before_all = ":",
                  const std::string& after_all = ":") {
    std::string text = kProgram;
    const std::string head = "#!/bin/sh\ntwo() { " + two + "; }\nbefore_all() { " + before_all +
                             "; }\nafter_all() { " + after_all + "; }\n";
    text.replace(0, std::string("#!/bin/sh\n").size(), head);
    const std::string path = folder_.write("program", text);
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    ChildLimits limits;
    limits.silence_s = 1;
    seen_.clear();
    return run_gtest({path}, {}, limits, [this](const std::string& test, std::size_t done, std::size_t all) {
      seen_.push_back(test + " " + std::to_string(done) + "/" + std::to_string(all));
    });
  }
  test::Folder folder_;
  Names seen_;
};

const Names kOthers = {"A.one", "P/B.three/0", "P/B.three/1"};

TEST_F(GtestRun, AllPass) {
  const GtestResult result = run("printf 'no newline'; echo '[       OK ] A.two (1 ms)'");
  EXPECT_TRUE(result.ok()) << result.problem;
  EXPECT_EQ(result.passed, (Names{"A.one", "A.two", "P/B.three/0", "P/B.three/1"}));
  EXPECT_EQ(seen_, (Names{"A.one 0/4", "A.two 1/4", "P/B.three/0 2/4", "P/B.three/1 3/4"}));
  EXPECT_GT(result.peak_bytes, 100'000u);
}

TEST_F(GtestRun, FailuresAndSkipsKeepTheirMessages) {
  GtestResult result =
      run("echo 'it is 3'; echo '[  FAILED  ] A.two, where GetParam() = 3 (1 ms)'", ":", "exit 1");
  EXPECT_EQ(result.passed, kOthers);
  ASSERT_EQ(result.failed.size(), 1u);
  EXPECT_EQ(result.failed[0].name, "A.two");
  EXPECT_EQ(result.failed[0].message, "it is 3\n");
  EXPECT_TRUE(result.problem.empty()) << result.problem;
  EXPECT_FALSE(result.ok());
  result = run("echo 'no such driver'; echo '[  SKIPPED ] A.two (1 ms)'");
  EXPECT_TRUE(result.ok());
  ASSERT_EQ(result.skipped.size(), 1u);
  EXPECT_EQ(result.skipped[0].message, "no such driver\n");
}

TEST_F(GtestRun, ACrashStopsOneTest) {
  const GtestResult result = run("echo begun; kill -SEGV $$");
  EXPECT_EQ(result.passed, kOthers);
  ASSERT_EQ(result.failed.size(), 1u);
  EXPECT_EQ(result.failed[0].message, "crashed (signal 11)\nbegun\n");
  EXPECT_TRUE(result.not_run.empty());
}

TEST_F(GtestRun, AHangStopsOneTest) {
  const GtestResult result = run("sleep 60");
  EXPECT_EQ(result.passed, kOthers);
  ASSERT_EQ(result.failed.size(), 1u);
  EXPECT_EQ(result.failed[0].message.substr(0, 9), "timed out");
  EXPECT_LT(result.seconds, 30);
}

TEST_F(GtestRun, WhatAProgramLeavesBehindIsNotWaitedFor) {
  const GtestResult result = run("sleep 60 & echo '[       OK ] A.two (1 ms)'");
  EXPECT_TRUE(result.ok());
  EXPECT_LT(result.seconds, 30);
}

TEST_F(GtestRun, AProgramThatNeverGetsToItsTests) {
  const GtestResult result = run(":", "echo 'no display'; kill -ABRT $$");
  EXPECT_EQ(result.not_run.size(), 4u);
  EXPECT_EQ(result.problem, "crashed (signal 6) before its tests were run");
  EXPECT_TRUE(result.passed.empty());
  EXPECT_TRUE(run_gtest({folder_.path("none")}, {}, {}, {}).problem.starts_with("could not be started"));
}

TEST_F(GtestRun, ATestThatDoesNotEndIsNotPassed) {
  const GtestResult result = run("exit 0");
  ASSERT_EQ(result.failed.size(), 1u);
  EXPECT_EQ(result.failed[0].name, "A.two");
  EXPECT_EQ(result.passed, kOthers);
}

TEST_F(GtestRun, ACrashAfterTheLastTest) {
  const GtestResult result = run("echo '[       OK ] A.two (1 ms)'", ":", "kill -SEGV $$");
  EXPECT_EQ(result.passed.size(), 4u);
  EXPECT_EQ(result.problem, "crashed (signal 11) after its last test");
}

}  // namespace
}  // namespace karst::device
