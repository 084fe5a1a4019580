// SPDX-License-Identifier: MIT
// Sources: console_ioctl(4), libseat.h.
#include "platform/seat/seat.h"

#include <fcntl.h>
#include <linux/kd.h>
#include <linux/major.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/signalfd.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {  // which the header lacks
#include <libseat.h>
}

namespace karst {
namespace {

// Signals by which the kernel asks for the terminal and gives it back.
constexpr int kReleaseSignal = SIGUSR1;
constexpr int kAcquireSignal = SIGUSR2;

constexpr const char* kBackend = "LIBSEAT_BACKEND";

// The virtual terminal of this process: its standard input where that is one, else the one in front.
std::string find_terminal() {
  struct stat status {};
  if (fstat(STDIN_FILENO, &status) == 0 && S_ISCHR(status.st_mode) && major(status.st_rdev) == TTY_MAJOR &&
      minor(status.st_rdev) >= 1 && minor(status.st_rdev) <= MAX_NR_CONSOLES) {
    return "/dev/tty" + std::to_string(minor(status.st_rdev));
  }
  const int fd = open("/dev/tty0", O_RDONLY | O_CLOEXEC | O_NOCTTY);
  if (fd < 0) return {};
  vt_stat state{};
  const bool known = ioctl(fd, VT_GETSTATE, &state) == 0;
  close(fd);
  return known ? "/dev/tty" + std::to_string(state.v_active) : std::string();
}

class DirectSeat final : public Seat {
 public:
  // console: null where no terminal will be taken.
  DirectSeat(ConsoleState* console, LogLine log) : console_(console), log_(std::move(log)) {}

  ~DirectSeat() override {
    if (console_ != nullptr) restore_terminal(*console_, log_);
    if (terminal_ >= 0) close(terminal_);
    if (signals_ >= 0) close(signals_);
  }

  void take_terminal() {
    const std::string path = find_terminal();
    if (path.empty()) {
      log_("no virtual terminal: none is switched");
      return;
    }
    terminal_ = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOCTTY);
    if (terminal_ < 0) {
      log_(errno_text(path + " is not taken over", errno));
      return;
    }
    if (const Error error = take(path); !error.ok()) {
      log_(path + " is not taken over: " + error.text());
      restore_terminal(*console_, log_);
      close(terminal_);
      terminal_ = -1;
    }
  }

  int open_device(const std::string& path, SeatDevice& device) override {
    const int fd = open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0) return -errno;
    device = {fd, fd};
    return 0;
  }

  void close_device(SeatDevice& device) override {
    if (device.fd >= 0) close(device.fd);
    device = {};
  }

  int fd() const override { return signals_; }

  void dispatch() override {
    signalfd_siginfo info{};
    while (signals_ >= 0 && read(signals_, &info, sizeof info) == sizeof info) {
      if (static_cast<int>(info.ssi_signo) == kReleaseSignal) {
        active_ = false;
      } else {
        ioctl(terminal_, VT_RELDISP, VT_ACKACQ);
        active_ = true;
      }
    }
  }

  bool active() const override { return active_; }
  void released() override {
    if (terminal_ >= 0) ioctl(terminal_, VT_RELDISP, 1);
  }
  bool sets_master() const override { return true; }
  void switch_terminal(int number) override {
    if (terminal_ >= 0) ioctl(terminal_, VT_ACTIVATE, number);
  }
  const char* name() const override { return "direct"; }

 private:
  Error take(const std::string& path) {
    int display_mode = 0;
    int keyboard_mode = 0;
    vt_mode switching{};
    if (ioctl(terminal_, KDGETMODE, &display_mode) != 0) return errno_text("KDGETMODE", errno);
    if (ioctl(terminal_, KDGKBMODE, &keyboard_mode) != 0) return errno_text("KDGKBMODE", errno);
    if (ioctl(terminal_, VT_GETMODE, &switching) != 0) return errno_text("VT_GETMODE", errno);
    std::snprintf(console_->terminal, sizeof console_->terminal, "%s", path.c_str());
    console_->display_mode = display_mode;
    console_->keyboard_mode = keyboard_mode;
    console_->switching = switching;
    // Signals before the ioctl that makes the kernel send them: by default they kill.
    sigset_t awaited;
    sigemptyset(&awaited);
    sigaddset(&awaited, kReleaseSignal);
    sigaddset(&awaited, kAcquireSignal);
    sigprocmask(SIG_BLOCK, &awaited, nullptr);
    signals_ = signalfd(-1, &awaited, SFD_CLOEXEC | SFD_NONBLOCK);
    if (signals_ < 0) return errno_text("signalfd", errno);
    console_->terminal_taken.store(true);
    vt_mode ours{};
    ours.mode = VT_PROCESS;
    ours.relsig = kReleaseSignal;
    ours.acqsig = kAcquireSignal;
    if (ioctl(terminal_, VT_SETMODE, &ours) != 0) return errno_text("VT_SETMODE", errno);
    if (ioctl(terminal_, KDSETMODE, static_cast<long>(KD_GRAPHICS)) != 0) {
      return errno_text("KDSETMODE", errno);
    }
    // Keys are read through libinput; here they must not reach a shell. A keyboard left on is an annoyance
    // and no reason to fail.
    if (ioctl(terminal_, KDSKBMODE, static_cast<long>(K_OFF)) != 0) log_(errno_text("KDSKBMODE", errno));
    vt_stat state{};
    const bool in_front =
        ioctl(terminal_, VT_GETSTATE, &state) != 0 || path == "/dev/tty" + std::to_string(state.v_active);
    active_ = in_front;
    return {};
  }

  ConsoleState* console_;
  LogLine log_;
  int terminal_ = -1;
  int signals_ = -1;
  bool active_ = true;
};

class LibSeat final : public Seat {
 public:
  explicit LibSeat(LogLine log) : log_(std::move(log)) {}
  ~LibSeat() override {
    if (seat_ != nullptr) libseat_close_seat(seat_);
  }

  Error open() {
    libseat_set_log_level(LIBSEAT_LOG_LEVEL_SILENT);
    static const libseat_seat_listener kListener = {
        [](libseat*, void* self) { static_cast<LibSeat*>(self)->active_ = true; },
        [](libseat*, void* self) { static_cast<LibSeat*>(self)->active_ = false; }};
    // libseat's own keeper, which it takes last, can open nothing without root but says so only at the card.
    if (geteuid() != 0 && std::getenv(kBackend) == nullptr) {
      for (const char* backend : {"seatd", "logind"}) {
        setenv(kBackend, backend, 1);
        seat_ = libseat_open_seat(&kListener, this);
        const int reason = errno;
        unsetenv(kBackend);
        errno = reason;
        if (seat_ != nullptr) break;
      }
    } else {
      seat_ = libseat_open_seat(&kListener, this);
    }
    if (seat_ == nullptr) return errno_text("libseat", errno);
    // The keeper tells soon whether the seat is ours now; without that it is when the terminal comes back.
    for (int i = 0; i < kFirstWaits && !active_; ++i) {
      if (libseat_dispatch(seat_, kFirstWait_ms) < 0) return errno_text("libseat", errno);
    }
    return {};
  }

  int open_device(const std::string& path, SeatDevice& device) override {
    int fd = -1;
    const int id = libseat_open_device(seat_, path.c_str(), &fd);
    if (id < 0) return errno != 0 ? -errno : -EACCES;
    device = {fd, id};
    return 0;
  }

  void close_device(SeatDevice& device) override {
    if (device.id >= 0) libseat_close_device(seat_, device.id);
    if (device.fd >= 0) close(device.fd);
    device = {};
  }

  int fd() const override { return libseat_get_fd(seat_); }
  void dispatch() override {
    if (libseat_dispatch(seat_, 0) < 0 && active_) {
      log_(errno_text("the seat's keeper is gone", errno));
      active_ = false;
    }
  }
  bool active() const override { return active_; }
  void released() override { libseat_disable_seat(seat_); }
  bool sets_master() const override { return false; }
  void switch_terminal(int number) override { libseat_switch_session(seat_, number); }
  const char* name() const override { return "libseat"; }

 private:
  static constexpr int kFirstWaits = 10;
  static constexpr int kFirstWait_ms = 100;

  LogLine log_;
  libseat* seat_ = nullptr;
  bool active_ = false;
};

}  // namespace

std::unique_ptr<Seat> open_seat(SeatKind kind, ConsoleState* console, const LogLine& log, Error& error) {
  error = {};
  if (kind != SeatKind::direct) {
    auto seat = std::make_unique<LibSeat>(log);
    const Error reason = seat->open();
    if (reason.ok()) return seat;
    if (kind == SeatKind::libseat) {
      error = reason;
      return nullptr;
    }
    log(reason.text() + "; opening devices directly");
  }
  auto seat = std::make_unique<DirectSeat>(console, log);
  seat->take_terminal();
  return seat;
}

std::unique_ptr<Seat> open_device_access() {
  return std::make_unique<DirectSeat>(nullptr, [](const std::string&) {});
}

}  // namespace karst
