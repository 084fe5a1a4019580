// SPDX-License-Identifier: MIT
// SIGTERM, SIGINT and SIGHUP as a descriptor.
#pragma once

#include <optional>

#include "app/screen/end_watch.h"

namespace karst::app {

// They are blocked from the first line on, so that none ends the program before the console is given back.
class Signals {
 public:
  // may_exit: as EndWatch has it.
  explicit Signals(bool may_exit);
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  ~Signals();
  int fd() const { return fd_; }
  struct Taken {
    bool end = false;         // SIGTERM or SIGINT
    bool statistics = false;  // SIGHUP
  };
  // What came since the last call. Each signal is there once at most, however often it was sent, and one read
  // takes them all: whoever sends without end is not waited for.
  Taken take();

 private:
  int fd_ = -1;
  std::optional<EndWatch> watch_;
};

}  // namespace karst::app
