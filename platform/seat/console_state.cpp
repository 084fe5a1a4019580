// SPDX-License-Identifier: MIT
#include "platform/seat/console_state.h"

#include <fcntl.h>
#include <linux/kd.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <xf86drm.h>

#include <cerrno>
#include <new>

namespace karst {
namespace {

constexpr int kPassedOn[] = {SIGTERM, SIGINT, SIGHUP};
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

// Waits for the child and passes signals on to it. Returns its wait status.
int wait_for(pid_t child, const sigset_t& awaited) {
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno == ECHILD)) return status;
    siginfo_t info{};
    const int signal_number = sigwaitinfo(&awaited, &info);
    if (signal_number > 0 && signal_number != SIGCHLD) kill(child, signal_number);
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
  sigset_t awaited;
  sigset_t before;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGCHLD);
  for (const int number : kPassedOn) sigaddset(&awaited, number);
  sigprocmask(SIG_BLOCK, &awaited, &before);
  const pid_t supervisor = getpid();
  const pid_t child = fork();
  if (child <= 0) {
    if (child < 0) log(errno_text("runs without a supervisor", errno));
    sigprocmask(SIG_SETMASK, &before, nullptr);
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (getppid() != supervisor) raise(SIGTERM);  // it died before the line above
    }
    return -1;
  }
  const int status = wait_for(child, awaited);
  if (WIFSIGNALED(status)) {
    log("ended by signal " + std::to_string(WTERMSIG(status)) + "; giving the console back");
  }
  restore_console(state, log);
  return exit_code(status);
}

}  // namespace karst
