// SPDX-License-Identifier: MIT
#include "app/common/arguments.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>

#include "platform/base/freed_memory.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

template <class T>
bool read_whole(std::string_view text, T& out) {
  // from_chars knows no leading '+', which people write for offsets.
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), out);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

}  // namespace

std::string number_text(double number) {
  char buffer[32];
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, number).ptr);
}

Error parse_number(std::string_view text, std::string_view what, double min, double max, double& out) {
  double number = 0;
  if (!read_whole(text, number)) return std::string(what) + ": " + quote(text) + " is not a number";
  if (!(number >= min && number <= max)) {
    return std::string(what) + ": " + excerpt(text) + " is not in " + number_text(min) + " to " +
           number_text(max);
  }
  out = number;
  return {};
}

Error parse_integer(std::string_view text, std::string_view what, std::int64_t min, std::int64_t max,
                    std::int64_t& out) {
  std::int64_t number = 0;
  if (!read_whole(text, number)) return std::string(what) + ": " + quote(text) + " is not a whole number";
  if (number < min || number > max) {
    return std::string(what) + ": " + excerpt(text) + " is not in " + std::to_string(min) + " to " +
           std::to_string(max);
  }
  out = number;
  return {};
}

NumbersRead read_numbers(std::string_view text, char separator, std::span<double> out, std::size_t marked,
                         bool* mark) {
  if (mark != nullptr) *mark = false;
  std::string_view rest = text;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (separator == ' ') rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
    const std::size_t end = separator == ' ' ? rest.find_first_of(" \t") : rest.find(separator);
    const std::string_view part = rest.substr(0, end);
    if (part.empty()) return {NumbersFault::count, {}};
    const bool has_mark = mark != nullptr && i == marked && part.front() == '~';
    if (has_mark) *mark = true;
    if (!read_whole(part.substr(has_mark ? 1 : 0), out[i]) || !std::isfinite(out[i])) {
      return {NumbersFault::number, part};
    }
    const bool last = i + 1 == out.size();
    if (end == std::string_view::npos) return {last ? NumbersFault::none : NumbersFault::count, {}};
    rest.remove_prefix(end + 1);
  }
  const bool blank = separator == ' ' && rest.find_first_not_of(" \t") == std::string_view::npos;
  return {blank ? NumbersFault::none : NumbersFault::count, {}};
}

Error parse_numbers(std::string_view text, std::string_view what, char separator, std::span<double> out,
                    std::size_t marked, bool* mark) {
  const NumbersRead read = read_numbers(text, separator, out, marked, mark);
  switch (read.fault) {
    case NumbersFault::none:
      return {};
    case NumbersFault::number:
      return std::string(what) + ": " + quote(read.part) + " is not a number";
    case NumbersFault::count:
      break;
  }
  return std::string(what) + ": " + quote(text) + " is not " + std::to_string(out.size()) + " numbers";
}

Error parse_size(std::string_view text, std::string_view what, int max, int& width, int& height) {
  const std::size_t cross = text.find('x');
  if (cross == std::string_view::npos) {
    return std::string(what) + ": " + quote(text) + " is not WIDTHxHEIGHT";
  }
  std::int64_t w = 0;
  std::int64_t h = 0;
  if (Error error = parse_integer(text.substr(0, cross), what, 1, max, w); !error.ok()) return error;
  if (Error error = parse_integer(text.substr(cross + 1), what, 1, max, h); !error.ok()) return error;
  width = static_cast<int>(w);
  height = static_cast<int>(h);
  return {};
}

Error flush_output() {
  // The flag remembers what an earlier flush lost.
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
  return "standard output: cannot write";
}

void keep_standard_files() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) >= 0) continue;
    // The lowest number that is free: this one. For the other direction, so that its use fails.
    [[maybe_unused]] const int same = open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
}

void print_error(std::string_view program, std::string_view message) {
  const std::string line = std::string(program) + ": " + printable(message) + "\n";
  std::fputs(line.c_str(), stderr);
}

int run_program(const char* name, int argc, char** argv, int (*run)(std::span<const char* const> words)) {
  keep_standard_files();
  keep_freed_memory();
  try {
    const std::span<char* const> all(argv, static_cast<std::size_t>(argc));
    const std::span<const char* const> words(all.empty() ? nullptr : all.data() + 1,
                                             all.empty() ? 0 : all.size() - 1);
    const int code = run(words);
    if (code != kExitOk) return code;
    if (const Error error = flush_output(); !error.ok()) {
      print_error(name, error.text());
      return kExitFailure;
    }
    return code;
  } catch (const std::exception& e) {  // of the standard library: no memory
    print_error(name, e.what());
    return kExitFailure;
  }
}

}  // namespace karst::app
