// SPDX-License-Identifier: MIT
#include "tests/bake/child_test_tasks.h"

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <new>
#include <stdexcept>

namespace karst::bake {
namespace {

using Request = std::span<const std::byte>;
using Bytes = std::vector<std::byte>;

int number(Request request) {
  int result = 0;
  std::memcpy(&result, request.data(), sizeof result);
  return result;
}

Error tell_process(Request, Bytes& result) {
  const pid_t process = getpid();
  result.resize(sizeof process);
  std::memcpy(result.data(), &process, sizeof process);
  return {};
}

Error count(Request request, Bytes& result) {
  for (int k = 0; k < number(request); ++k) result.push_back(static_cast<std::byte>(k % 251));
  return {};
}

Error fail(Request, Bytes&) {
  return "x.png: no such colour";
}

Error throw_one(Request, Bytes&) {
  throw std::runtime_error("a library's own");
}

Error raise_one(Request request, Bytes&) {
  std::signal(number(request), SIG_DFL);
  std::raise(number(request));
  return {};
}

Error leave(Request, Bytes&) {
  std::_Exit(0);
}

Error spin(Request, Bytes&) {
  while (std::clock() >= 0) continue;
  return {};
}

Error tell_limits(Request, Bytes& result) {
  rlimit limit{};
  rusage used{};
  if (getrlimit(RLIMIT_CPU, &limit) != 0 || getrusage(RUSAGE_SELF, &used) != 0) return "x.png: no limits";
  const auto seconds = static_cast<std::uint64_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  const ToldLimits told{limit.rlim_cur - seconds, alarm(0)};
  result.resize(sizeof told);
  std::memcpy(result.data(), &told, sizeof told);
  return {};
}

Error take(Request request, Bytes& result) {
  // Not new, which ends these tests where there is none.
  void* const room = std::malloc(static_cast<std::size_t>(number(request)) << 20);
  if (room == nullptr) throw std::bad_alloc();
  std::free(room);
  result.resize(64);
  return {};
}

}  // namespace

const ChildTask kTellProcess{"tell process", tell_process};
const ChildTask kCount{"count", count};
const ChildTask kFail{"fail", fail};
const ChildTask kThrow{"throw", throw_one};
const ChildTask kRaise{"raise", raise_one};
const ChildTask kLeave{"leave", leave};
const ChildTask kSpin{"spin", spin};
const ChildTask kTake{"take", take};
const ChildTask kTellLimits{"tell limits", tell_limits};

std::span<const ChildTask> child_test_tasks() {
  static const ChildTask kTasks[] = {kTellProcess, kCount, kFail, kThrow,     kRaise,
                                     kLeave,       kSpin,  kTake, kTellLimits};
  return kTasks;
}

}  // namespace karst::bake
