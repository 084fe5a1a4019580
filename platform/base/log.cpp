// SPDX-License-Identifier: MIT
#include "platform/base/log.h"

#include <cstdlib>
#include <cstring>

namespace karst {

std::string errno_text(const std::string& what, int error) {
  char text[128] = "";
  const int positive = std::abs(error);
  const char* said = strerror_r(positive, text, sizeof text);
  return what + ": " + said;
}

}  // namespace karst
