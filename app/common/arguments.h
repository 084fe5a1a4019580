// SPDX-License-Identifier: MIT
// Command line arguments: --name VALUE, --name=VALUE, -n VALUE, --flag, and positional ones; "--" ends the
// options. Every function that can fail returns an empty string on success, else one line for the user.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace karst::app {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;  // a file, an image, a camera or the machine is not as it must be
inline constexpr int kExitUsage = 2;    // the command line is wrong

struct Option {
  std::string_view name;    // without dashes
  char letter = 0;          // short form, 0: none
  bool takes_value = true;  // false: a flag
};

class Arguments {
 public:
  // words: without the program's and the command's name; options and words must outlive the object.
  // Each option may be given once. A word that begins with a dash and a digit or point is a value, not an
  // option.
  [[nodiscard]] std::string parse(std::span<const char* const> words, std::span<const Option> options);

  bool has(std::string_view name) const { return value(name).has_value(); }
  // A flag that was given has the value "".
  std::optional<std::string_view> value(std::string_view name) const;
  std::span<const std::string_view> positional() const { return positional_; }

 private:
  struct Given {
    std::string_view name;
    std::string_view value;
  };
  std::vector<Given> given_;
  std::vector<std::string_view> positional_;
};

// what: how messages name the value, for instance "--fov". Ranges are inclusive; NaN is never accepted.
[[nodiscard]] std::string parse_number(std::string_view text, std::string_view what, double min, double max,
                                       double& out);
[[nodiscard]] std::string parse_integer(std::string_view text, std::string_view what, std::int64_t min,
                                        std::int64_t max, std::int64_t& out);
// Exactly out.size() finite numbers with `separator` between them ("X,Y,Z"); ' ' stands for any run of
// blanks.
[[nodiscard]] std::string parse_numbers(std::string_view text, std::string_view what, char separator,
                                        std::span<double> out);
// "1280x720": two integers, each in [1, max].
[[nodiscard]] std::string parse_size(std::string_view text, std::string_view what, int max, int& width,
                                     int& height);

// Prints "program: message" as one line to stderr; control characters (a newline in a file name) become '?'.
void print_error(std::string_view program, std::string_view message);

}  // namespace karst::app
