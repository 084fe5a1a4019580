// SPDX-License-Identifier: MIT
// The names of a run's pictures: one name, or one with a place for the frame's number.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "platform/base/error.h"

namespace karst::app {

class OutputName {
 public:
  // pattern: at most one of %d, %1d .. %9d, %01d .. %09d stands for the frame's number; %% is a percent sign.
  Error parse(std::string_view pattern);

  // A pattern without a place for the number gets "_%04d" before its extension where there are several
  // frames.
  std::string frame(std::size_t number, bool several) const;

 private:
  std::string before_;
  std::string after_;
  std::size_t digits_ = 0;
  char fill_ = ' ';
  bool numbered_ = false;
};

}  // namespace karst::app
