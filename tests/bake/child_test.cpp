// SPDX-License-Identifier: MIT
// What comes back from a process that reads for this one: bytes, its own error, or how it died.
#include "bake/base/child.h"

#include "tests/bake/child_test_tasks.h"

#include <gtest/gtest.h>
#include <sys/types.h>

#include <csignal>
#include <cstring>

namespace karst::bake {
namespace {

using Bytes = std::vector<std::byte>;

std::span<const std::byte> bytes_of(const int& number) {
  return std::as_bytes(std::span(&number, 1));
}

std::string error_of(const ChildLimits& limits, const ChildTask& task, int number = 0) {
  Bytes result(3);
  const std::string error = run_in_child("x.png", limits, task, bytes_of(number), result).text();
  EXPECT_TRUE(result.empty());
  return error;
}

// A child's number, by a task that does nothing else.
pid_t child() {
  ChildLimits limits;
  limits.result_bytes = sizeof(pid_t);
  Bytes result;
  EXPECT_EQ(run_in_child("x.png", limits, kTellProcess, {}, result).text(), "");
  pid_t process = 0;
  if (result.size() == sizeof process) std::memcpy(&process, result.data(), sizeof process);
  return process;
}

TEST(Child, HandsBackBytesAndErrors) {
  ChildLimits limits;
  limits.result_bytes = 1'000'000;
  const pid_t first = child();
  Bytes result;
  EXPECT_EQ(run_in_child("x.png", limits, kCount, bytes_of(1'000'000), result).text(), "");
  ASSERT_EQ(result.size(), 1'000'000u);
  for (std::size_t k = 0; k < result.size(); ++k) ASSERT_EQ(result[k], static_cast<std::byte>(k % 251));
  EXPECT_EQ(error_of({}, kFail), "x.png: no such colour");
  EXPECT_EQ(error_of({}, kThrow), "x.png: cannot be read: a library's own");
  EXPECT_EQ(child(), first) << "errors of files are no reason for another process";
  EXPECT_NE(error_of({}, kCount, 10).find("x.png: its reader sends more"), std::string::npos);
  EXPECT_NE(child(), first);
}

TEST(Child, ADeathIsAnError) {
  for (const int signal : {SIGSEGV, SIGABRT}) {
    EXPECT_NE(error_of({}, kRaise, signal).find("x.png: its reader crashed"), std::string::npos);
  }
  EXPECT_NE(error_of({}, kLeave).find("x.png: its reader"), std::string::npos);
  ChildLimits limits;
  limits.cpu_seconds = 1;
  EXPECT_NE(error_of(limits, kSpin).find("x.png: reading was stopped: it took more than 1 s"),
            std::string::npos);
  EXPECT_GT(child(), 0) << "the next file is read all the same";
}

// Of the processor's time and of the clock's, for each task anew.
TEST(Child, TimeHasALimit) {
  ChildLimits limits;
  limits.result_bytes = sizeof(ToldLimits);
  for (const unsigned seconds : {5u, 2u, 40u}) {
    limits.cpu_seconds = seconds;
    Bytes result;
    ASSERT_EQ(run_in_child("x.png", limits, kTellLimits, bytes_of(0), result).text(), "");
    ToldLimits told;
    ASSERT_EQ(result.size(), sizeof told);
    std::memcpy(&told, result.data(), sizeof told);
    EXPECT_GE(told.cpu_seconds, seconds);
    EXPECT_LE(told.cpu_seconds, seconds + 2);
    EXPECT_LE(told.clock_seconds, 4 * seconds);
    EXPECT_GT(told.clock_seconds, 3 * seconds);
  }
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
TEST(Child, MemoryHasALimit) {
  ChildLimits limits;
  limits.memory_bytes = 32u << 20;
  EXPECT_NE(error_of(limits, kTake, 64).find("x.png: reading takes more than 32 MiB"), std::string::npos);
  limits.memory_bytes = 256u << 20;
  limits.result_bytes = 64;
  Bytes result;
  EXPECT_EQ(run_in_child("x.png", limits, kTake, bytes_of(64), result).text(), "");
  EXPECT_EQ(result.size(), 64u);
}
#endif

}  // namespace
}  // namespace karst::bake
