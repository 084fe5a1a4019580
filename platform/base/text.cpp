// SPDX-License-Identifier: MIT
#include "platform/base/text.h"

namespace karst {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

struct CodeRange {
  char32_t first, last;
};
// Unicode 15: general categories Cc, Zl, Zp, and of Cf what turns directions or has no width.
constexpr CodeRange kUnprintable[] = {{0x00, 0x1F},     {0x7F, 0x9F},     {0xAD, 0xAD},     {0x61C, 0x61C},
                                      {0x200B, 0x200F}, {0x2028, 0x202E}, {0x2060, 0x2069}, {0xFEFF, 0xFEFF}};

}  // namespace

std::size_t utf8_character(std::string_view text, char32_t& code) {
  if (text.empty()) return 0;
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t bytes = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
  if (bytes == 0 || first > 0xF4 || bytes > text.size()) return 0;
  code = bytes == 1 ? first : first & (0x7Fu >> bytes);
  for (std::size_t k = 1; k < bytes; ++k) {
    const auto next = static_cast<unsigned char>(text[k]);
    if ((next & 0xC0u) != 0x80) return 0;
    code = code << 6 | (next & 0x3Fu);
  }
  // Longer than needed, half of a pair of UTF-16, or beyond the last.
  constexpr char32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_half = code >= 0xD800 && code <= 0xDFFF;
  return code < kLeast[bytes] || is_half || code > 0x10FFFF ? 0 : bytes;
}

bool is_printable(char32_t code) {
  for (const CodeRange& range : kUnprintable) {
    if (code >= range.first && code <= range.last) return false;
  }
  return true;
}

std::string printable(std::string_view text) {
  std::string line;
  while (!text.empty()) {
    char32_t code = 0;
    const std::size_t bytes = utf8_character(text, code);
    if (bytes > 0 && is_printable(code)) {
      line += text.substr(0, bytes);
    } else {
      line += '?';
    }
    text.remove_prefix(bytes == 0 ? 1 : bytes);
  }
  return line;
}

std::string excerpt(std::string_view text) {
  if (text.size() <= kMostQuote) return std::string(text);
  std::size_t end = 0;
  for (;;) {
    char32_t code = 0;
    const std::size_t bytes = utf8_character(text.substr(end), code);
    if (end + (bytes == 0 ? 1 : bytes) > kMostQuote) break;
    end += bytes == 0 ? 1 : bytes;
  }
  return std::string(text.substr(0, end)) + "...";
}

std::string quote(std::string_view text) {
  std::string line(1, '\'');
  line += excerpt(text);
  return line += '\'';
}

std::string_view without_byte_order_mark(std::string_view text) {
  return text.starts_with(kByteOrderMark) ? text.substr(kByteOrderMark.size()) : text;
}

}  // namespace karst
