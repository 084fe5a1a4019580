// SPDX-License-Identifier: MIT
#include "app/common/status_text.h"

namespace karst::app {

std::string status_text(const std::string& subject, const Status& status) {
  std::string text = subject + ": " + status.what();
  const std::string field = status.field();
  const std::string value = std::to_string(status.value());
  switch (status.code()) {
    case StatusCode::corrupt:
    case StatusCode::unsupported:
      if (!field.empty()) text += " (" + field + (status.value() > 0 ? ", at byte " + value : "") + ")";
      break;
    case StatusCode::limit_reached:
      if (!field.empty()) text += " (" + field + (status.value() > 0 ? ": " + value : "") + ")";
      break;
    case StatusCode::invalid_argument:
      if (!field.empty()) text += " (" + field + ")";
      break;
    case StatusCode::ok:
      break;
  }
  return text;
}

}  // namespace karst::app
