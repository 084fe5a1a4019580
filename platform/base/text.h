// SPDX-License-Identifier: MIT
// Text from outside: UTF-8 that may be none, and what terminals would obey.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace karst {

// Bytes of the character (RFC 3629) that text begins with, and its code; 0 where it begins with none.
std::size_t utf8_character(std::string_view text, char32_t& code);

// Whether it neither controls a terminal (C0, DEL, C1, ends of lines) nor turns the direction of text, and is
// seen.
bool is_printable(char32_t code);

// One line that can be printed anywhere: a ? for each byte that is no UTF-8 and each character that is not
// printable.
std::string printable(std::string_view text);

// What messages quote of text that somebody else wrote, at most kMostQuote bytes of it: cut between
// characters, with ... where something is left out. quote(): in single quotes.
inline constexpr std::size_t kMostQuote = 80;
std::string excerpt(std::string_view text);
std::string quote(std::string_view text);

// Without the byte order mark that some editors begin UTF-8 with.
std::string_view without_byte_order_mark(std::string_view text);

}  // namespace karst
