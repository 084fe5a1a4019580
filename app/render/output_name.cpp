// SPDX-License-Identifier: MIT
#include "app/render/output_name.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

// The number with at least `digits` characters.
std::string pad(std::size_t number, std::size_t digits, char fill) {
  const std::string text = std::to_string(number);
  return text.size() < digits ? std::string(digits - text.size(), fill) + text : text;
}

}  // namespace

Error OutputName::parse(std::string_view pattern) {
  *this = OutputName();
  std::string* part = &before_;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (pattern[i] != '%') {
      *part += pattern[i];
      continue;
    }
    ++i;
    if (i < pattern.size() && pattern[i] == '%') {
      *part += '%';
      continue;
    }
    const bool zero = i < pattern.size() && pattern[i] == '0';
    if (zero) ++i;
    const bool width = i < pattern.size() && pattern[i] >= '1' && pattern[i] <= '9';
    const std::size_t digits = width ? static_cast<std::size_t>(pattern[i++] - '0') : 0;
    if (i >= pattern.size() || pattern[i] != 'd' || numbered_) {
      return "--output: " + quote(pattern) + " may hold one %d or %04d, and %% for a percent sign";
    }
    numbered_ = true;
    digits_ = digits;
    fill_ = zero ? '0' : ' ';
    part = &after_;
  }
  return {};
}

std::string OutputName::frame(std::size_t number, bool several) const {
  if (numbered_) return before_ + pad(number, digits_, fill_) + after_;
  if (!several) return before_;
  const std::size_t dot = before_.rfind('.');
  const std::size_t slash = before_.rfind('/');
  const bool extension =
      dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
  const std::size_t end = extension ? dot : before_.size();
  return before_.substr(0, end) + '_' + pad(number, 4, '0') + before_.substr(end);
}

}  // namespace karst::app
