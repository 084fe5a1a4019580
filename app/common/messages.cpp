// SPDX-License-Identifier: MIT
#include "app/common/messages.h"

namespace karst::app {

bool Messages::may_say(std::int64_t now, About about) {
  const std::int64_t more = (now - filled_at_ns_) / kInterval_ns;
  if (left_ + more >= kBurst) {
    left_ = kBurst;
    filled_at_ns_ = now;
  } else if (more > 0) {
    left_ += static_cast<int>(more);
    filled_at_ns_ += more * kInterval_ns;
  }
  if (left_ <= (about == About::own ? 0 : kBurst - kBurstOfOthers)) {
    ++left_out_;
    return false;
  }
  --left_;
  if (left_out_ > 0) {
    print_(std::to_string(left_out_) + " more lines were left out");
    left_out_ = 0;
  }
  return true;
}

}  // namespace karst::app
