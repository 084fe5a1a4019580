// SPDX-License-Identifier: MIT
#include "app/command_line/command_line.h"

#include "app/common/arguments.h"
#include "platform/base/text.h"

namespace karst::app {
namespace {

bool looks_like_option(std::string_view word) {
  if (word.size() < 2 || word[0] != '-') return false;
  const char next = word[1];
  return !(next >= '0' && next <= '9') && next != '.';  // -12.5,3,4 is a camera
}

const OptionRow* find_row(const CommandSpec& spec, std::string_view word) {
  const OptionRow* found = nullptr;
  for_each_option(spec, [&](const OptionRow& row) {
    const bool is_it = word.starts_with("--") ? word.substr(2) == row.name
                                              : word.size() == 2 && row.letter != 0 && word[1] == row.letter;
    if (is_it && found == nullptr) found = &row;
  });
  return found;
}

Error read_word(std::string_view text, const OptionRow& row, const std::string& what, std::int64_t& place) {
  place = 0;
  for (std::string_view rest = row.words;; ++place) {
    const std::size_t blank = rest.find(' ');
    if (rest.substr(0, blank) == text) return {};
    if (blank == std::string_view::npos) break;
    rest.remove_prefix(blank + 1);
  }
  return what + ": " + quote(text) + " is not one of " + row.words;
}

Error read_value(const OptionRow& row, const std::string& what, OptionValue& value) {
  switch (row.kind) {
    case ValueKind::flag:
      value.integer = 1;
      return {};
    case ValueKind::text:
      return value.text.empty() ? what + ": it is empty" : std::string();
    case ValueKind::file:
      return value.text.empty() ? what + ": the file name is empty" : std::string();
    case ValueKind::number:
      return parse_number(value.text, what, row.min, row.max, value.number);
    case ValueKind::integer:
      return parse_integer(value.text, what, static_cast<std::int64_t>(row.min),
                           static_cast<std::int64_t>(row.max), value.integer);
    case ValueKind::word:
      return read_word(value.text, row, what, value.integer);
    case ValueKind::size:
      return parse_size(value.text, what, static_cast<int>(row.max), value.width, value.height);
    case ValueKind::other:
      return {};
  }
  return {};
}

}  // namespace

void assign_text(std::string& out, std::string_view text) {
  out = text;
}

Error CommandLine::parse(std::span<const char* const> words, const CommandSpec& spec) {
  spec_ = &spec;
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
    const OptionRow* row = find_row(spec, name);
    if (row == nullptr) return "unknown option " + quote(name);
    if (find(*row) != nullptr) return "option " + quote(name) + " is given twice";
    std::string_view value;
    if (equals != std::string_view::npos) {
      if (row->kind == ValueKind::flag) return "option " + quote(name) + " takes no value";
      value = word.substr(equals + 1);
    } else if (row->kind != ValueKind::flag) {
      if (i + 1 == words.size()) return "option " + quote(name) + " needs a value";
      value = words[++i];
      if (looks_like_option(value)) return "option " + quote(name) + " needs a value, not " + quote(value);
    }
    given_.push_back({row, value});
  }
  return {};
}

const CommandLine::Given* CommandLine::find(const OptionRow& row) const {
  for (const Given& given : given_) {
    if (given.row == &row) return &given;
  }
  return nullptr;
}

bool CommandLine::has(std::string_view name) const {
  for (const Given& given : given_) {
    if (name == given.row->name) return true;
  }
  return false;
}

Error CommandLine::store(std::span<void* const> targets) const {
  for (std::size_t part = 0; part < spec_->parts.size(); ++part) {
    for (const OptionGroup& group : spec_->parts[part]) {
      for (const OptionRow& row : group.rows) {
        const Given* given = find(row);
        if (given == nullptr) continue;
        const std::string what = std::string("--") + row.name;
        OptionValue value;
        value.what = what;
        value.text = given->value;
        if (Error error = read_value(row, what, value); !error.ok()) return error;
        if (row.store == nullptr) continue;
        if (Error error = row.store(targets[part], value); !error.ok()) return error;
      }
    }
  }
  return {};
}

}  // namespace karst::app
