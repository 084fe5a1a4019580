// SPDX-License-Identifier: MIT
#include "platform/seat/console_state.h"

#include <fcntl.h>
#include <linux/kd.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include <xf86drm.h>

#include <cerrno>
#include <cstdint>
#include <new>
#include <string>

namespace karst {
namespace {

constexpr int kPassedOn[] = {SIGTERM, SIGINT, SIGHUP};
// After SIGTERM or SIGINT; systemd and its like kill everything, the supervisor too, a little later.
constexpr std::int64_t kPatience_ms = 3000;
// The card of a program that was just killed is busy until the kernel has closed its files.
constexpr int kMasterTries = 20;
constexpr useconds_t kMasterPause_us = 50'000;

bool become_master(int fd) {
  for (int i = 0; i < kMasterTries; ++i) {
    if (drmIsMaster(fd) == 1 || drmSetMaster(fd) == 0) return true;
    usleep(kMasterPause_us);
  }
  return false;
}

int exit_code(int status) {
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

std::int64_t clock_ms() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

// Waits for the child and passes signals on to it; one that does not end when it is told to is killed.
// signals: a signalfd of SIGCHLD and kPassedOn. Returns its wait status.
int wait_for(pid_t child, int signals, const LogLine& log) {
  std::int64_t kill_at = 0;  // 0: it was not told to end
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno == ECHILD)) return status;
    const std::int64_t left = kill_at - clock_ms();
    if (kill_at > 0 && left <= 0) {
      log("does not answer " + std::to_string(kPatience_ms / 1000) + " s after it was told to end: killed");
      kill(child, SIGKILL);
      waitpid(child, &status, 0);
      return status;
    }
    pollfd came{signals, POLLIN, 0};
    poll(&came, 1, kill_at > 0 ? static_cast<int>(left) : -1);
    // Each signal is there once at most, and one read takes them all: a flood of one hides no other.
    signalfd_siginfo infos[8];
    const ssize_t got = read(signals, infos, sizeof infos);
    for (std::size_t n = 0; got > 0 && n < static_cast<std::size_t>(got) / sizeof infos[0]; ++n) {
      const int number = static_cast<int>(infos[n].ssi_signo);
      if (number == SIGCHLD) continue;
      kill(child, number);
      if (number != SIGHUP && kill_at == 0) kill_at = clock_ms() + kPatience_ms;
    }
  }
}

}  // namespace

ConsoleState* share_console_state() {
  void* memory =
      mmap(nullptr, sizeof(ConsoleState), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return memory == MAP_FAILED ? nullptr : new (memory) ConsoleState;
}

void restore_terminal(ConsoleState& state, const LogLine& log) {
  if (!state.terminal_taken.load()) return;
  const int fd = open(state.terminal, O_RDWR | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) {
    log(errno_text(std::string("cannot give back the terminal ") + state.terminal, errno));
    return;
  }
  // The keyboard first: whatever follows, the user can type again.
  ioctl(fd, KDSKBMODE, static_cast<long>(state.keyboard_mode));
  ioctl(fd, KDSETMODE, static_cast<long>(state.display_mode));
  ioctl(fd, VT_SETMODE, &state.switching);
  close(fd);
  state.terminal_taken.store(false);
}

void restore_crtc(ConsoleState& state, int card_fd, const LogLine& log) {
  if (!state.crtc_taken.load()) return;
  state.crtc_taken.store(false);
  if (state.framebuffer == 0) return;
  const int failed = drmModeSetCrtc(card_fd, state.crtc, state.framebuffer, state.x, state.y,
                                    &state.connector, 1, &state.mode);
  // ENOENT: its framebuffer is gone with the program that made it; the kernel's own console needs no help.
  if (failed != 0 && failed != -ENOENT) log(errno_text("cannot give back the screen", failed));
}

void restore_console(ConsoleState& state, const LogLine& log) {
  if (state.crtc_taken.load()) {
    const int fd = open(state.card, O_RDWR | O_CLOEXEC);
    if (fd >= 0 && become_master(fd)) {
      restore_crtc(state, fd, log);
    } else {
      log(errno_text(std::string("cannot give back the screen of ") + state.card, errno));
    }
    if (fd >= 0) close(fd);
  }
  // Switching the terminal to text makes the kernel's console draw itself, now that nobody holds the card.
  restore_terminal(state, log);
}

int supervise(ConsoleState& state, const LogLine& log) {
  // Whoever ignores it hands that down, and the kernel then keeps no child's end for its parent.
  signal(SIGCHLD, SIG_DFL);
  sigset_t awaited;
  sigset_t before;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  for (const int number : kPassedOn) sigaddset(&awaited, number);
  sigprocmask(SIG_BLOCK, &awaited, &before);
  const int signals = signalfd(-1, &awaited, SFD_CLOEXEC | SFD_NONBLOCK);
  const pid_t supervisor = getpid();
  const pid_t child = signals < 0 ? -1 : fork();
  if (child <= 0) {
    if (child < 0) log(errno_text("runs without a supervisor", errno));
    if (signals >= 0) close(signals);
    sigprocmask(SIG_SETMASK, &before, nullptr);
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (getppid() != supervisor) raise(SIGTERM);  // it died before the line above
    }
    return -1;
  }
  const int status = wait_for(child, signals, log);
  close(signals);
  if (WIFSIGNALED(status)) {
    log("ended by signal " + std::to_string(WTERMSIG(status)) + "; giving the console back");
  }
  restore_console(state, log);
  return exit_code(status);
}

}  // namespace karst
