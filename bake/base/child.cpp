// SPDX-License-Identifier: MIT
#include "bake/base/child.h"

#include "platform/base/log.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <iterator>
#include <new>

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

constexpr char kWord[] = "--as-child";  // the one argument of a child
constexpr int kChannel = STDIN_FILENO;  // a child's socket to its parent
constexpr std::size_t kMostMessage = 4'096;

// Both sides are the same program, so numbers are sent as they lie in memory.
struct Asked {  // followed by the task's name and the request
  std::uint64_t memory_bytes = 0;
  std::uint64_t request_bytes = 0;
  std::uint32_t cpu_seconds = 0;
  std::uint32_t name_bytes = 0;
};
enum class Outcome : std::uint64_t { done, failed, broken, no_memory };  // broken: its message has no subject
struct Answer {  // followed by the result, or by a message
  Outcome outcome = Outcome::failed;
  std::uint64_t bytes = 0;
};

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string(bytes >> 20) + " MiB";
}

// All of it; false where the other side is gone.
bool send_all(int socket, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

bool receive_all(int socket, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t count = recv(socket, bytes.data(), bytes.size(), 0);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
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

// The seconds that this process has run, rounded up.
std::uint64_t cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) + 2;
}

// The soft limit, which the next task may raise again.
bool set_limit(decltype(RLIMIT_AS) what, std::uint64_t value) {
  rlimit limit{};
  if (getrlimit(what, &limit) != 0) return false;
  limit.rlim_cur = std::min<rlim_t>(static_cast<rlim_t>(value), limit.rlim_max);
  return setrlimit(what, &limit) == 0;
}

Answer message(Outcome outcome, std::string_view text, std::vector<std::byte>& result) {
  const auto bytes = std::as_bytes(std::span(text.substr(0, kMostMessage)));
  result.assign(bytes.begin(), bytes.end());
  return {outcome, result.size()};
}

Answer work_within(const Asked& asked, const ChildTask& task, std::span<const std::byte> request,
                   std::vector<std::byte>& result) {
  const std::uint64_t before = address_bytes();
  if (before == 0 || !set_limit(RLIMIT_CPU, cpu_seconds() + asked.cpu_seconds) ||
      (kLimitsMemory && !set_limit(RLIMIT_AS, before + asked.memory_bytes)))
    return message(Outcome::broken, errno_text("what reading takes cannot be limited", errno), result);
  alarm(4 * asked.cpu_seconds);
  try {
    const Error error = task.work(request, result);
    alarm(0);
    return error.ok() ? Answer{Outcome::done, result.size()} : message(Outcome::failed, error.text(), result);
  } catch (const std::bad_alloc&) {
    result = {};
    return {Outcome::no_memory, 0};
  } catch (const std::exception& e) {
    alarm(0);
    return message(Outcome::broken, std::string("cannot be read: ") + e.what(), result);
  }
}

// Until the parent closes its end.
int serve(std::span<const ChildTask> tasks) {
  for (;;) {
    Asked asked;
    if (!receive_all(kChannel, std::as_writable_bytes(std::span(&asked, 1)))) return 0;
    std::string name(asked.name_bytes, '\0');
    std::vector<std::byte> request(asked.request_bytes), result;
    if (!receive_all(kChannel, std::as_writable_bytes(std::span(name))) || !receive_all(kChannel, request))
      return 1;
    const auto task =
        std::find_if(tasks.begin(), tasks.end(), [&](const ChildTask& t) { return t.name == name; });
    if (task == tasks.end()) return 1;
    const Answer answer = work_within(asked, *task, request, result);
    if (!send_all(kChannel, bytes_of(answer)) || !send_all(kChannel, result)) return 1;
  }
}

// The process that works, and this side's end of the channel to it.
class Child {
 public:
  Child() = default;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { end(); }

  Error start() {
    if (process_ > 0) return {};
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return errno_text("socketpair", errno);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], kChannel);
    for (const int output : {STDOUT_FILENO, STDERR_FILENO})
      posix_spawn_file_actions_addopen(&files, output, "/dev/null", O_WRONLY, 0);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
    char program[] = "karst-bake", word[sizeof kWord];
    std::copy(std::begin(kWord), std::end(kWord), word);
    char* words[] = {program, word, nullptr};
    const int failed = posix_spawn(&process_, "/proc/self/exe", &files, &attributes, words, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    close(ends[1]);
    channel_ = ends[0];
    if (failed == 0) return {};
    process_ = -1;
    end();
    return errno_text("posix_spawn", failed);
  }

  // The exit status of waitpid.
  int end() {
    int status = 0;
    if (channel_ >= 0) close(channel_);
    if (process_ > 0) {
      while (waitpid(process_, &status, 0) < 0 && errno == EINTR) continue;
    }
    channel_ = -1;
    process_ = -1;
    return status;
  }

  // For one that is not to go on, whatever it does.
  int kill_and_end() {
    if (process_ > 0) kill(process_, SIGKILL);
    return end();
  }

  int channel() const { return channel_; }

 private:
  pid_t process_ = -1;
  int channel_ = -1;
};

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

std::optional<int> serve_as_child(std::span<const char* const> words, std::span<const ChildTask> tasks) {
  if (words.size() != 2 || std::string_view(words[1]) != kWord) return {};
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  set_limit(RLIMIT_CORE, 0);
  int type = 0;
  socklen_t size = sizeof type;
  if (getsockopt(kChannel, SOL_SOCKET, SO_TYPE, &type, &size) != 0) {
    std::fprintf(stderr, "karst-bake: %s: started by karst-bake itself, to read images\n", kWord);
    return 2;
  }
  _exit(serve(tasks));  // destructors of libraries are nobody's wish here
}

Error run_in_child(const std::string& subject, const ChildLimits& limits, const ChildTask& task,
                   std::span<const std::byte> request, std::vector<std::byte>& result) {
  static Child children[static_cast<std::size_t>(ChildTask::Library::count)];
  Child& child = children[static_cast<std::size_t>(task.library)];
  result.clear();
  if (Error error = child.start(); !error.ok()) return subject + ": cannot be read: " + error.text();
  const Asked asked{limits.memory_bytes, request.size(), limits.cpu_seconds,
                    static_cast<std::uint32_t>(task.name.size())};
  Answer answer;
  if (!send_all(child.channel(), bytes_of(asked)) ||
      !send_all(child.channel(), std::as_bytes(std::span(task.name))) ||
      !send_all(child.channel(), request) ||
      !receive_all(child.channel(), std::as_writable_bytes(std::span(&answer, 1))))
    return death(subject, limits, child.end());
  const bool done = answer.outcome == Outcome::done;
  if (answer.bytes > (done ? limits.result_bytes : kMostMessage)) {
    child.kill_and_end();
    return subject + ": its reader sends more than it was asked for; the file is damaged";
  }
  result.resize(static_cast<std::size_t>(answer.bytes));
  if (!receive_all(child.channel(), result)) {
    result.clear();
    return death(subject, limits, child.end());
  }
  if (done) return {};
  if (answer.outcome == Outcome::no_memory) {
    child.kill_and_end();  // libraries need not be whole after it
    return subject + ": reading takes more than " + mebibytes(limits.memory_bytes) +
           " of memory; make it smaller or save it without compression";
  }
  const std::string message(reinterpret_cast<const char*>(result.data()), result.size());
  result.clear();
  return answer.outcome == Outcome::broken ? subject + ": " + message : message;
}

}  // namespace karst::bake
