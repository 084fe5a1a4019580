// SPDX-License-Identifier: MIT
// What comes back from a process that reads for this one: bytes, its own error, or how it died.
#include "bake/base/child.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <ctime>
#include <new>

namespace karst::bake {
namespace {

using Bytes = std::vector<std::byte>;

std::string error_of(const ChildLimits& limits, const ChildWork& work) {
  Bytes result(3);
  const std::string error = run_in_child("x.png", limits, work, result).text();
  EXPECT_TRUE(result.empty());
  return error;
}

TEST(Child, HandsBackBytesAndErrors) {
  ChildLimits limits;
  limits.result_bytes = 1'000'000;
  const auto count = [](Bytes& out) {
    for (int k = 0; k < 1'000'000; ++k) out.push_back(static_cast<std::byte>(k % 251));
    return Error();
  };
  Bytes result;
  EXPECT_EQ(run_in_child("x.png", limits, count, result).text(), "");
  ASSERT_EQ(result.size(), 1'000'000u);
  for (std::size_t k = 0; k < result.size(); ++k) ASSERT_EQ(result[k], static_cast<std::byte>(k % 251));
  EXPECT_EQ(error_of({}, [](Bytes&) { return Error("x.png: no such colour"); }), "x.png: no such colour");
  EXPECT_NE(error_of({}, count).find("x.png: its reader"), std::string::npos) << "more than it may send";
}

TEST(Child, ADeathIsAnError) {
  for (const int signal : {SIGSEGV, SIGABRT}) {
    const auto die = [signal](Bytes&) {
      std::signal(signal, SIG_DFL);
      std::raise(signal);
      return Error();
    };
    EXPECT_NE(error_of({}, die).find("x.png: its reader crashed"), std::string::npos);
  }
  EXPECT_NE(error_of({}, [](Bytes&) -> Error { std::_Exit(0); }).find("x.png: its reader"),
            std::string::npos);
  ChildLimits limits;
  limits.cpu_seconds = 1;
  const auto spin = [](Bytes&) -> Error {
    while (std::clock() >= 0) continue;
    return {};
  };
  EXPECT_NE(error_of(limits, spin).find("x.png: reading was stopped: it took more than 1 s"),
            std::string::npos);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && !defined(__clang__)
TEST(Child, MemoryHasALimit) {
  ChildLimits limits;
  limits.memory_bytes = 32u << 20;
  const auto take = [](Bytes& out) {
    void* const room = std::malloc(64u << 20);  // not new, which ends these tests where there is none
    if (room == nullptr) throw std::bad_alloc();
    std::free(room);
    out.resize(64);
    return Error();
  };
  EXPECT_NE(error_of(limits, take).find("x.png: reading takes more than 32 MiB"), std::string::npos);
  limits.memory_bytes = 256u << 20;
  limits.result_bytes = 64;
  Bytes result;
  EXPECT_EQ(run_in_child("x.png", limits, take, result).text(), "");
  EXPECT_EQ(result.size(), 64u);
}
#endif

}  // namespace
}  // namespace karst::bake
