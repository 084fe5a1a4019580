// SPDX-License-Identifier: MIT
#include "app/screen/signals.h"

#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>

namespace karst::app {

Signals::Signals(bool may_exit) {
  sigset_t awaited;
  sigemptyset(&awaited);
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&awaited, number);
  sigprocmask(SIG_BLOCK, &awaited, nullptr);
  fd_ = signalfd(-1, &awaited, SFD_CLOEXEC | SFD_NONBLOCK);
  signal(SIGPIPE, SIG_IGN);
  watch_.emplace(fd_, may_exit);
}

Signals::~Signals() {
  watch_.reset();
  if (fd_ >= 0) close(fd_);
}

Signals::Taken Signals::take() {
  std::array<signalfd_siginfo, 4> infos{};
  const ssize_t got = read(fd_, infos.data(), sizeof infos);
  Taken taken;
  for (std::size_t n = 0; got > 0 && n < static_cast<std::size_t>(got) / sizeof infos[0]; ++n) {
    (infos[n].ssi_signo == SIGHUP ? taken.statistics : taken.end) = true;
  }
  if (taken.end) watch_->told();
  return taken;
}

}  // namespace karst::app
