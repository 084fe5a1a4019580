// SPDX-License-Identifier: MIT
#include "app/common/status_text.h"

#include "platform/base/error.h"

namespace karst::app {

std::string status_text(const std::string& subject, const Status& status) {
  return Error(subject, status).text();
}

}  // namespace karst::app
