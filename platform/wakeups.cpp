// SPDX-License-Identifier: MIT
// Sources: libudev(3), timerfd_create(2).
#include "platform/wakeups.h"

#include <libudev.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

namespace karst {

HotplugMonitor::HotplugMonitor(const LogLine& log) {
  udev_ = udev_new();
  if (udev_ != nullptr) monitor_ = udev_monitor_new_from_netlink(udev_, "kernel");
  if (monitor_ != nullptr && (udev_monitor_filter_add_match_subsystem_devtype(monitor_, "drm", nullptr) < 0 ||
                              udev_monitor_enable_receiving(monitor_) < 0)) {
    udev_monitor_unref(monitor_);
    monitor_ = nullptr;
  }
  if (monitor_ == nullptr) log("the kernel's messages cannot be heard: monitors are asked every 2 s");
}

HotplugMonitor::~HotplugMonitor() {
  if (monitor_ != nullptr) udev_monitor_unref(monitor_);
  if (udev_ != nullptr) udev_unref(udev_);
}

int HotplugMonitor::fd() const {
  return monitor_ != nullptr ? udev_monitor_get_fd(monitor_) : -1;
}

bool HotplugMonitor::take() {
  bool any = false;
  while (monitor_ != nullptr) {
    udev_device* device = udev_monitor_receive_device(monitor_);
    if (device == nullptr) break;
    udev_device_unref(device);
    any = true;
  }
  return any;
}

// A timer that never ends but is cancelled whenever the wall clock jumps, which it does on waking up.
ResumeTimer::ResumeTimer() : fd_(timerfd_create(CLOCK_REALTIME, TFD_CLOEXEC | TFD_NONBLOCK)) {
  if (fd_ >= 0) arm();
}

ResumeTimer::~ResumeTimer() {
  if (fd_ >= 0) close(fd_);
}

void ResumeTimer::arm() {
  itimerspec far{};
  far.it_value.tv_sec = static_cast<time_t>(INT32_MAX);  // 2038: some systems know no later time
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  if (now.tv_sec > INT32_MAX / 4 * 3) far.it_value.tv_sec = now.tv_sec + INT32_MAX / 4;
  if (timerfd_settime(fd_, TFD_TIMER_ABSTIME | TFD_TIMER_CANCEL_ON_SET, &far, nullptr) != 0) {
    close(fd_);
    fd_ = -1;
  }
}

bool ResumeTimer::take() {
  std::uint64_t expired = 0;
  if (fd_ < 0) return false;
  const ssize_t got = read(fd_, &expired, sizeof expired);
  if (got < 0 && errno != ECANCELED) return false;
  arm();
  return true;
}

}  // namespace karst
