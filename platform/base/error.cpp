// SPDX-License-Identifier: MIT
#include "platform/base/error.h"

namespace karst {

Error::Error(const std::string& subject, const Status& status) {
  if (status.ok()) return;
  text_ = subject + ": " + status.what();
  const std::string field = status.field();
  if (field.empty()) return;
  const bool has_value = status.value() > 0 && status.code() != StatusCode::invalid_argument;
  const char* before = status.code() == StatusCode::limit_reached ? ": " : ", at byte ";
  text_ += " (" + field + (has_value ? before + std::to_string(status.value()) : "") + ")";
}

}  // namespace karst
