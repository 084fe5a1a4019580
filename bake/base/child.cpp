// SPDX-License-Identifier: MIT
#include "bake/base/child.h"

#include "app/files/regular_file.h"
#include "platform/base/log.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <span>

namespace karst::bake {
namespace {

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define KARST_HAS_SHADOW 1
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define KARST_HAS_SHADOW 1
#endif
#ifdef KARST_HAS_SHADOW
constexpr bool kLimitsMemory = false;
#else
constexpr bool kLimitsMemory = true;
#endif

constexpr std::byte kDone{1}, kFailed{2};  // the first byte that comes back
constexpr std::size_t kMostMessage = 4'096;

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MiB";
}

// Of the address space that this process has now.
std::uint64_t address_bytes() {
  unsigned long pages = 0;
  std::FILE* const file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr) return 0;
  if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
  std::fclose(file);
  return std::uint64_t{pages} * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

bool set_limit(decltype(RLIMIT_AS) what, std::uint64_t value) {
  rlimit limit{};
  if (getrlimit(what, &limit) != 0) return false;
  limit.rlim_cur = std::min<rlim_t>(static_cast<rlim_t>(value), limit.rlim_max);
  limit.rlim_max = limit.rlim_cur;
  return setrlimit(what, &limit) == 0;
}

Error limited_work(const std::string& subject, const ChildLimits& limits, const ChildWork& work,
                   std::vector<std::byte>& result) {
  const std::uint64_t before = address_bytes();
  if (before == 0 || !set_limit(RLIMIT_CORE, 0) || !set_limit(RLIMIT_CPU, limits.cpu_seconds) ||
      (kLimitsMemory && !set_limit(RLIMIT_AS, before + limits.memory_bytes)))
    return errno_text(subject + ": cannot limit what reading takes", errno);
  try {
    return work(result);
  } catch (const std::bad_alloc&) {
    return subject + ": reading takes more than " + mebibytes(limits.memory_bytes) +
           " of memory; make it smaller or save it without compression";
  } catch (const std::exception& e) {
    return subject + ": cannot be read: " + e.what();
  }
}

[[noreturn]] void run_child(const std::string& subject, const ChildLimits& limits, const ChildWork& work,
                            int out) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  alarm(4 * limits.cpu_seconds);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGALRM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE})
    std::signal(signal, SIG_DFL);
  std::signal(SIGPIPE, SIG_IGN);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  std::vector<std::byte> result;
  const Error error = limited_work(subject, limits, work, result);
  const std::string message = error.text().substr(0, kMostMessage);
  const std::byte first = error.ok() ? kDone : kFailed;
  const bool sent = app::write_all(out, {&first, 1}) == 0 &&
                    app::write_all(out, error.ok() ? std::span<const std::byte>(result)
                                                   : std::as_bytes(std::span(message))) == 0;
  _exit(sent ? 0 : 1);
}

// Up to the end, at most `most` bytes.
bool read_all(int file, std::size_t most, std::vector<std::byte>& bytes) {
  std::byte block[1 << 16];
  for (;;) {
    const ssize_t count = read(file, block, sizeof block);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return count == 0;
    if (static_cast<std::size_t>(count) > most - bytes.size()) return false;
    bytes.insert(bytes.end(), block, block + count);
  }
}

Error death(const std::string& subject, const ChildLimits& limits, int status) {
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL) {
    return subject + ": reading was stopped: it took more than " + std::to_string(limits.cpu_seconds) +
           " s or than the machine has memory for; make it smaller or save it without compression";
  }
  return subject + ": its reader crashed; the file is damaged, or takes more memory than " +
         mebibytes(limits.memory_bytes);
}

}  // namespace

Error run_in_child(const std::string& subject, const ChildLimits& limits, const ChildWork& work,
                   std::vector<std::byte>& result) {
  result.clear();
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return errno_text(subject + ": cannot be read: pipe", errno);
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    run_child(subject, limits, work, ends[1]);
  }
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return errno_text(subject + ": cannot be read: fork", errno);
  }
  const bool whole = read_all(ends[0], std::max(limits.result_bytes, kMostMessage) + 1, result);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) continue;
  Error error;
  if (!whole || status != 0 || result.empty()) {
    error = death(subject, limits, status);
  } else if (result[0] == kFailed) {
    error = std::string(reinterpret_cast<const char*>(result.data()) + 1, result.size() - 1);
  } else {
    result.erase(result.begin());
  }
  if (!error.ok()) result.clear();
  return error;
}

}  // namespace karst::bake
