// SPDX-License-Identifier: MIT
// A run of karst-device: the parts of a plan, one after the other, whatever becomes of each; and the JSON
// that tells what came of them, written anew after every part.
#pragma once

#include <string>
#include <vector>

#include "platform/base/error.h"
#include "tests/device/run/child.h"
#include "tests/device/run/plan.h"

namespace karst::device {

struct SessionOptions {
  std::string self;    // this program, for probing in a process of its own
  std::string folder;  // what make.sh made: bin/, worlds/, pictures/, plans/, commit
  std::string plan = "full";
  std::vector<Part> parts;
  std::string json = "karst-device.json";  // the file to write
  std::string keep;                        // folder for drawn pictures that are not as stored; empty: none
  ChildLimits limits;
};

// complete: all parts were run, whatever came of them. good: and none failed. Errors are of the JSON file.
struct SessionEnd {
  bool complete = false;
  bool good = false;
};
Error run_session(const SessionOptions& options, SessionEnd& end);

}  // namespace karst::device
