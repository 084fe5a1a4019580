// SPDX-License-Identifier: MIT
// Options as data. A program's command line is read, explained by --help, described in its man page and
// completed by the shell from the same rows:
//
//   struct DrawOptions { double fov_deg = 60; };
//   constexpr OptionRow kRows[] = {
//       {.name = "fov", .kind = ValueKind::number, .value = "DEG", .initial = "60", .unit = "degrees",
//        .min = 1, .max = 170, .help = "of the picture's height", .store = put<&DrawOptions::fov_deg>}};
//   constexpr OptionGroup kGroups[] = {{"picture", kRows}};
//   constexpr OptionPart kParts[] = {kGroups};
//   constexpr CommandSpec kSpec = {.name = "draw", .parts = kParts};
//   CommandLine line;  DrawOptions options;  void* targets[] = {&options};
//   if (error = line.parse(words, kSpec); error.ok()) error = line.store(targets);
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "platform/base/error.h"

namespace karst::app {

// What the value of an option must be; everything else is told in one line.
enum class ValueKind : std::uint8_t {
  flag,     // there is none
  text,     // not empty
  file,     // not empty, the name of a file
  number,   // min..max
  integer,  // min..max, whole
  word,     // one of `words`
  size,     // WIDTHxHEIGHT, each 1..max
  other,    // store() reads it, and says what is wrong with it
};

struct OptionValue {
  std::string_view what;     // how messages name the option: "--size"
  std::string_view text;     // as given
  double number = 0;         // of numbers
  std::int64_t integer = 0;  // of integers; of words their place among the words; 1 for a flag
  int width = 0;             // of sizes
  int height = 0;
};

struct OptionRow {
  const char* name;  // without dashes
  char letter = 0;   // short form, 0: none
  ValueKind kind = ValueKind::flag;
  const char* value = nullptr;    // how help names the value: "WxH"
  const char* initial = nullptr;  // what holds without the option, as it would be given
  const char* unit = nullptr;     // of numbers
  double min = 0;                 // numbers: inclusive range; sizes: max
  double max = 0;
  const char* words = nullptr;  // "error distance full"
  const char* help = "";        // a clause; the range, the unit and what holds without it are added
  // Called once where the option is given and its value is what kind says. The error tells what is
  // wrong with the value. Null: it is enough that the option is there.
  Error (*store)(void* options, const OptionValue& value) = nullptr;
};

struct OptionGroup {
  const char* title;  // begins with a small letter a..z
  std::span<const OptionRow> rows;
};

// Groups whose rows store into one struct.
using OptionPart = std::span<const OptionGroup>;

struct CommandSpec {
  const char* name;   // "karst render"
  const char* brief;  // a clause: what it does
  const char* usage;  // behind the name; more than one way by newlines
  const char* about;  // paragraphs, an empty line between them
  std::span<const OptionPart> parts;
  const char* examples;  // a command a line
};

// --help belongs to every command.
inline constexpr OptionRow kHelpRow = {.name = "help", .letter = 'h', .help = "prints this text"};

// Calls visit(row) for every option of a command in the order of its help.
template <class Visit>
void for_each_option(const CommandSpec& spec, Visit visit) {
  for (const OptionPart& part : spec.parts) {
    for (const OptionGroup& group : part) {
      for (const OptionRow& row : group.rows) visit(row);
    }
  }
  visit(kHelpRow);
}

// --- storing

// In one place, because a program has many options of text.
void assign_text(std::string& out, std::string_view text);

template <class Member>
void assign(Member& out, const OptionValue& value) {
  if constexpr (std::is_same_v<Member, bool>) {
    out = value.integer != 0;
  } else if constexpr (std::is_floating_point_v<Member>) {
    out = value.number;
  } else if constexpr (std::is_integral_v<Member> || std::is_enum_v<Member>) {
    out = static_cast<Member>(value.integer);
  } else {
    assign_text(out, value.text);
  }
}

template <class Member>
struct OwnerOf;
template <class Owner, class Member>
struct OwnerOf<Member Owner::*> {
  using type = Owner;
};

// Stores into a member, or a member of a member: put<&ViewOptions::kms, &KmsOptions::card>. Text into
// strings, numbers into floating point, the rest into bool, integers and enums (words in their order).
template <auto first, auto... rest>
Error put(void* options, const OptionValue& value) {
  auto& owner = *static_cast<typename OwnerOf<decltype(first)>::type*>(options);
  assign(((owner.*first).*....*rest), value);
  return {};
}

// A flag that switches something off.
template <auto first, auto... rest>
Error put_false(void* options, const OptionValue&) {
  return put<first, rest...>(options, {});
}

}  // namespace karst::app
