// SPDX-License-Identifier: MIT
// Values that people write, and what they are told.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "platform/base/error.h"

namespace karst::app {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailure = 1;  // a file, an image, a camera or the machine is not as it must be
inline constexpr int kExitUsage = 2;    // the command line is wrong

// what: how messages name the value, for instance "--fov". Ranges are inclusive; NaN is never accepted.
Error parse_number(std::string_view text, std::string_view what, double min, double max, double& out);
Error parse_integer(std::string_view text, std::string_view what, std::int64_t min, std::int64_t max,
                    std::int64_t& out);
// Exactly out.size() finite numbers with `separator` between them ("X,Y,Z"); ' ' stands for any run of
// blanks. Where mark is not null, the number out[marked] may have a ~ before it; *mark tells whether it has.
Error parse_numbers(std::string_view text, std::string_view what, char separator, std::span<double> out,
                    std::size_t marked = 0, bool* mark = nullptr);
// The same without words, which cost more than the reading where most of what comes is wrong.
enum class NumbersFault { none, count, number };
struct NumbersRead {
  NumbersFault fault = NumbersFault::none;
  std::string_view part;  // of text: what is not a number
};
NumbersRead read_numbers(std::string_view text, char separator, std::span<double> out, std::size_t marked,
                         bool* mark);
// "1280x720": two integers, each in [1, max].
Error parse_size(std::string_view text, std::string_view what, int max, int& width, int& height);

// Whether all that was printed has reached standard output. What did not reach its reader (a full disk, a
// closed pipe) is a failure: programs ask before they end.
Error flush_output();

// The first call in main(): where standard input, output or error is closed, no file that is opened later
// takes its number, and so what is printed; reading or writing them goes on failing.
void keep_standard_files();

// Shortest text that reads back as the same number.
std::string number_text(double number);

// Prints "program: message" as one line to stderr; control characters (a newline in a file name) become '?'.
void print_error(std::string_view program, std::string_view message);

// What main() of a program does: run(), with the words behind its name, and what standard output and memory
// have to do with it. Returns the exit code.
int run_program(const char* name, int argc, char** argv, int (*run)(std::span<const char* const> words));

}  // namespace karst::app
