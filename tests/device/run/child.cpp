// SPDX-License-Identifier: MIT
#include "tests/device/run/child.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>

extern char** environ;

namespace karst::device {
namespace {

constexpr int kTickMs = 50;

std::atomic<bool> stop = false;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> result;
  for (std::string& word : words) result.push_back(word.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> joined_environment(const std::vector<std::string>& on_top) {
  std::vector<std::string> settings = on_top;
  for (char** e = environ; *e != nullptr; ++e) {
    const std::string setting = *e;
    const std::string name = setting.substr(0, setting.find('=') + 1);
    const bool replaced =
        std::any_of(on_top.begin(), on_top.end(), [&](const std::string& s) { return s.starts_with(name); });
    if (!replaced) settings.push_back(setting);
  }
  return settings;
}

// Cuts what arrives into lines.
class Lines {
 public:
  explicit Lines(const OnLine& on_line) : on_line_(on_line) {}
  // Whether there was something; never blocks.
  bool read_from(int pipe) {
    char bytes[4096];
    const ssize_t count = read(pipe, bytes, sizeof bytes);
    if (count <= 0) return false;
    text_.append(bytes, static_cast<std::size_t>(count));
    for (std::size_t end = 0; (end = text_.find('\n')) != std::string::npos; text_.erase(0, end + 1))
      on_line_(std::string_view(text_).substr(0, end));
    return true;
  }
  void finish() {
    if (!text_.empty()) on_line_(text_);
    text_.clear();
  }

 private:
  const OnLine& on_line_;
  std::string text_;
};

// Starts it in a process group of its own; returns 0 where it cannot be started.
pid_t start(std::vector<std::string> words, const std::vector<std::string>& environment, int output) {
  std::vector<std::string> settings = joined_environment(environment);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output, 1);
  posix_spawn_file_actions_adddup2(&actions, output, 2);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int error = posix_spawn(&child, words[0].c_str(), &actions, &attributes, pointers(words).data(),
                                pointers(settings).data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? child : 0;
}

}  // namespace

std::string how_it_ended(const ChildResult& result) {
  switch (result.end) {
    case ChildResult::End::exited:
      return result.code == 0 ? "" : "exit code " + std::to_string(result.code);
    case ChildResult::End::crashed:
      return "crashed (signal " + std::to_string(result.code) + ")";
    case ChildResult::End::timed_out:
      return "timed out after " + std::to_string(static_cast<int>(result.seconds)) + " s";
    case ChildResult::End::interrupted:
      return "interrupted";
    case ChildResult::End::not_started:
      break;
  }
  return "could not be started";
}

ChildResult run_child(const std::vector<std::string>& words, const std::vector<std::string>& environment,
                      const ChildLimits& limits, const OnLine& on_line) {
  ChildResult result;
  int ends[2];
  if (stop) {
    result.end = ChildResult::End::interrupted;
    return result;
  }
  if (pipe2(ends, O_CLOEXEC) != 0) return result;
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  const pid_t child = start(words, environment, ends[1]);
  close(ends[1]);
  if (child == 0) {
    close(ends[0]);
    return result;
  }
  const Clock::time_point begin = Clock::now();
  Clock::time_point heard = begin;
  Lines lines(on_line);
  rusage usage{};
  int status = 0;
  bool killed = false;
  for (bool running = true; running;) {
    pollfd waiting = {ends[0], POLLIN, 0};
    // Once all writers are gone there is nothing to poll for but the end.
    if (poll(&waiting, 1, kTickMs) > 0 && (waiting.revents & POLLIN) == 0) usleep(kTickMs * 1000);
    siginfo_t info{};
    running =
        waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
    while (lines.read_from(ends[0])) heard = Clock::now();
    const bool late = seconds_since(heard) > limits.silence_s || seconds_since(begin) > limits.total_s;
    if (running && !killed && (late || stop)) {
      result.end = stop ? ChildResult::End::interrupted : ChildResult::End::timed_out;
      kill(-child, SIGKILL);
      killed = true;
    }
  }
  lines.finish();
  close(ends[0]);
  kill(-child, SIGKILL);  // what it left behind; its number is its own until it is waited for
  wait4(child, &status, 0, &usage);
  result.seconds = seconds_since(begin);
  result.peak_bytes = static_cast<std::uint64_t>(usage.ru_maxrss) << 10;
  if (!killed) {
    result.end = WIFSIGNALED(status) ? ChildResult::End::crashed : ChildResult::End::exited;
    result.code = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
  }
  return result;
}

void interrupt_children() {
  stop = true;
}

bool interrupted() {
  return stop;
}

}  // namespace karst::device
