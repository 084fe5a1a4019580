// SPDX-License-Identifier: MIT
#include "app/screen/end_watch.h"

#include <poll.h>
#include <signal.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "app/common/arguments.h"
#include "app/files/file_source.h"
#include "platform/base/clock.h"

namespace karst::app {
namespace {

constexpr int kTick_ms = 20;
constexpr std::int64_t kMostWait_ns = 300'000'000;

bool end_is_pending() {
  sigset_t pending;
  return sigpending(&pending) == 0 &&
         (sigismember(&pending, SIGTERM) == 1 || sigismember(&pending, SIGINT) == 1);
}

}  // namespace

EndWatch::EndWatch(int signals, bool may_exit)
    : signals_(signals), may_exit_(may_exit), wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_ < 0) return;
  // Signals are the other thread's, also those that it blocks later: a seat's, of its terminal.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  has_thread_ = pthread_create(
                    &thread_, nullptr,
                    [](void* self) -> void* {
                      static_cast<EndWatch*>(self)->watch();
                      return nullptr;
                    },
                    this) == 0;
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

EndWatch::~EndWatch() {
  over_ = true;
  if (has_thread_) {
    eventfd_write(wake_, 1);
    pthread_join(thread_, nullptr);
  }
  if (wake_ >= 0) close(wake_);
}

void EndWatch::told() {
  FileSource::stop_reading();
  told_ = true;
  if (has_thread_) eventfd_write(wake_, 1);
}

void EndWatch::watch() {
  // Signals wait for the other thread; one that it has not taken yet is seen all the same.
  while (!told_ && !over_) {
    pollfd fds[] = {{signals_, POLLIN, 0}, {wake_, POLLIN, 0}};
    if (poll(fds, 2, -1) < 0 && errno != EINTR) return;
    if (end_is_pending()) {
      told_ = true;
    } else if (!told_ && !over_) {
      poll(nullptr, 0, kTick_ms);  // SIGHUP, which the other thread takes soon
    }
  }
  if (over_) return;
  FileSource::stop_reading();
  if (!comes_in_time() && may_exit_) _exit(kExitOk);
}

// False: a read hangs.
bool EndWatch::comes_in_time() {
  for (const std::int64_t start = now_ns(); !over_; poll(nullptr, 0, kTick_ms)) {
    if (now_ns() - start > kMostWait_ns && FileSource::is_reading()) return false;
  }
  return true;
}

}  // namespace karst::app
