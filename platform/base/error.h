// SPDX-License-Identifier: MIT
// The result of every function of the programs that can fail. The library has Status, which never allocates;
// here it is a line for the user.
#pragma once

#include <string>
#include <utility>

#include "karst/status.h"

namespace karst {

// One line without a full stop that names the file, option or device and what is wrong with it, ready to
// print; nothing where all went well.
class [[nodiscard]] Error {
 public:
  Error() = default;
  // An empty text is no error. Implicit, so that functions return their line as it stands.
  Error(std::string text) : text_(std::move(text)) {}
  Error(const char* text) : text_(text) {}
  // "canyon.karst: the checksum is wrong (header, at byte 28)"; none where status is ok. subject: the file or
  // option at fault.
  Error(const std::string& subject, const Status& status);

  bool ok() const { return text_.empty(); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace karst
