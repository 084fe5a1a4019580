// SPDX-License-Identifier: MIT
#include "bake/base/print_text.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace karst::bake {

void print(std::string& out, const char* format, ...) {
  char line[512];
  std::va_list values;
  va_start(values, format);
  const int length = std::vsnprintf(line, sizeof line, format, values);
  va_end(values);
  if (length > 0) out.append(line, std::min(static_cast<std::size_t>(length), sizeof line - 1));
}

}  // namespace karst::bake
