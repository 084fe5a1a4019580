// SPDX-License-Identifier: MIT
// What the system tells a display that sleeps: that monitors may have come or gone, and that the machine was
// asleep.
#pragma once

#include <string>

#include "platform/base/log.h"

struct udev;
struct udev_monitor;

namespace karst {

// Kernel messages about display cards. The kernel's own, not udev's: they come on systems without udevd too.
class HotplugMonitor {
 public:
  explicit HotplugMonitor(const LogLine& log);
  HotplugMonitor(const HotplugMonitor&) = delete;
  HotplugMonitor& operator=(const HotplugMonitor&) = delete;
  ~HotplugMonitor();

  int fd() const;  // -1: there is no monitor, ask the connectors now and then
  // Whether anything has arrived since the last call.
  bool take();

 private:
  udev* udev_ = nullptr;
  udev_monitor* monitor_ = nullptr;
};

// Readable after the machine has slept, or its clock was set.
class ResumeTimer {
 public:
  ResumeTimer();
  ResumeTimer(const ResumeTimer&) = delete;
  ResumeTimer& operator=(const ResumeTimer&) = delete;
  ~ResumeTimer();

  int fd() const { return fd_; }  // -1: the system has no such timer
  bool take();

 private:
  void arm();
  int fd_ = -1;
};

}  // namespace karst
