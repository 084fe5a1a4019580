// SPDX-License-Identifier: MIT
#include "app/common/arguments.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace karst::app {
namespace {

bool looks_like_option(std::string_view word) {
  if (word.size() < 2 || word[0] != '-') return false;
  const char next = word[1];
  return !(next >= '0' && next <= '9') && next != '.';  // -12.5,3,4 is a camera
}

std::string quoted(std::string_view text) {
  std::string result = "'";
  result += text;
  result += '\'';
  return result;
}

// Shortest text of a limit in a message.
std::string show(double number) {
  char buffer[32];
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
}

template <class T>
bool read_whole(std::string_view text, T& out) {
  // from_chars knows no leading '+', which people write for offsets.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), out);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

const Option* find_option(std::span<const Option> options, std::string_view word) {
  for (const Option& option : options) {
    if (word.starts_with("--") ? word.substr(2) == option.name
                               : word.size() == 2 && option.letter != 0 && word[1] == option.letter) {
      return &option;
    }
  }
  return nullptr;
}

}  // namespace

std::string Arguments::parse(std::span<const char* const> words, std::span<const Option> options) {
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string_view word = words[i];
    if (word == "--") {
      for (++i; i < words.size(); ++i) positional_.push_back(words[i]);
      return {};
    }
    if (!looks_like_option(word)) {
      positional_.push_back(word);
      continue;
    }
    const std::size_t equals = word.starts_with("--") ? word.find('=') : std::string_view::npos;
    const std::string_view name = word.substr(0, equals);
    const Option* option = find_option(options, name);
    if (option == nullptr) return "unknown option " + quoted(name);
    if (has(option->name)) return "option " + quoted(name) + " is given twice";
    std::string_view value;
    if (equals != std::string_view::npos) {
      if (!option->takes_value) return "option " + quoted(name) + " takes no value";
      value = word.substr(equals + 1);
    } else if (option->takes_value) {
      if (i + 1 == words.size()) return "option " + quoted(name) + " needs a value";
      value = words[++i];
      if (looks_like_option(value)) return "option " + quoted(name) + " needs a value, not " + quoted(value);
    }
    given_.push_back({option->name, value});
  }
  return {};
}

std::optional<std::string_view> Arguments::value(std::string_view name) const {
  for (const Given& given : given_) {
    if (given.name == name) return given.value;
  }
  return std::nullopt;
}

std::string parse_number(std::string_view text, std::string_view what, double min, double max, double& out) {
  double number = 0;
  if (!read_whole(text, number)) return std::string(what) + ": " + quoted(text) + " is not a number";
  if (!(number >= min && number <= max)) {
    return std::string(what) + ": " + std::string(text) + " is not in " + show(min) + " to " + show(max);
  }
  out = number;
  return {};
}

std::string parse_integer(std::string_view text, std::string_view what, std::int64_t min, std::int64_t max,
                          std::int64_t& out) {
  std::int64_t number = 0;
  if (!read_whole(text, number)) return std::string(what) + ": " + quoted(text) + " is not a whole number";
  if (number < min || number > max) {
    return std::string(what) + ": " + std::string(text) + " is not in " + std::to_string(min) + " to " +
           std::to_string(max);
  }
  out = number;
  return {};
}

std::string parse_numbers(std::string_view text, std::string_view what, char separator,
                          std::span<double> out) {
  const auto wrong_count = [&] {
    return std::string(what) + ": " + quoted(text) + " is not " + std::to_string(out.size()) + " numbers";
  };
  std::string_view rest = text;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (separator == ' ') rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    const std::size_t end = separator == ' ' ? rest.find_first_of(" \t") : rest.find(separator);
    const std::string_view part = rest.substr(0, end);
    if (part.empty()) return wrong_count();
    if (!read_whole(part, out[i]) || !std::isfinite(out[i])) {
      return std::string(what) + ": " + quoted(part) + " is not a number";
    }
    const bool last = i + 1 == out.size();
    if (end == std::string_view::npos) {
      if (!last) return wrong_count();
      return {};
    }
    rest.remove_prefix(end + 1);
  }
  const bool blank = separator == ' ' && rest.find_first_not_of(" \t") == std::string_view::npos;
  return blank ? std::string() : wrong_count();
}

std::string parse_size(std::string_view text, std::string_view what, int max, int& width, int& height) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) {
    return std::string(what) + ": " + quoted(text) + " is not WIDTHxHEIGHT";
  }
  std::int64_t w = 0;
  std::int64_t h = 0;
  if (std::string error = parse_integer(text.substr(0, cross), what, 1, max, w); !error.empty()) return error;
  if (std::string error = parse_integer(text.substr(cross + 1), what, 1, max, h); !error.empty())
    return error;
  width = static_cast<int>(w);
  height = static_cast<int>(h);
  return {};
}

void print_error(std::string_view program, std::string_view message) {
  std::string line = std::string(program) + ": " + std::string(message);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  line += '\n';
  std::fputs(line.c_str(), stderr);
}

}  // namespace karst::app
