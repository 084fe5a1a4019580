// SPDX-License-Identifier: MIT
// What a screen tells the user, which waits for the same thing again and again.
#pragma once

#include <string>
#include <utility>

#include "platform/base/log.h"

namespace karst {

class KmsLog {
 public:
  explicit KmsLog(LogLine log) : log_(std::move(log)) {}

  void tell(const std::string& line) const { log_(line); }
  // But not the same twice in a row.
  void say(const std::string& line) {
    if (line == last_said_) return;
    last_said_ = line;
    log_(line);
  }
  void forget() { last_said_.clear(); }
  const LogLine& log() const { return log_; }

 private:
  LogLine log_;
  std::string last_said_;
};

}  // namespace karst
