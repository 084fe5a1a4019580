// SPDX-License-Identifier: MIT
#include "app/command_line/help.h"

#include "app/common/arguments.h"

namespace karst::app {
namespace {

constexpr std::size_t kColumns = 108;
constexpr double kNoLimit = 1e9;
constexpr std::size_t kTextColumn = 28;  // where what an option does begins

// Adds a paragraph whose lines begin at `column`; the first goes on where `text` ends.
void add_wrapped(std::string_view paragraph, std::size_t column, std::string& text) {
  std::size_t at = text.size() - (text.rfind('\n') + 1);
  const auto go_to = [&] {
    text.append(at < column ? column - at : 0, ' ');
    at = std::max(at, column);
  };
  go_to();
  bool first = true;
  while (!paragraph.empty()) {
    const std::size_t end = std::min(paragraph.find(' '), paragraph.size());
    if (!first && at + 1 + end > kColumns) {
      text += '\n';
      at = 0;
      go_to();
    } else if (!first) {
      text += ' ';
      ++at;
    }
    text += paragraph.substr(0, end);
    at += end;
    paragraph.remove_prefix(std::min(end + 1, paragraph.size()));
    first = false;
  }
  text += '\n';
}

void add_option(const OptionRow& row, std::string& text) {
  const std::size_t start = text.size();
  text += "  ";
  if (row.letter != 0) {
    text.append("-").append(1, row.letter).append(", ");
  } else {
    text += "    ";
  }
  text.append("--").append(row.name);
  if (row.value != nullptr) text.append(" ").append(row.value);
  if (text.size() - start + 2 > kTextColumn) text += '\n';
  add_wrapped(explain(row), kTextColumn, text);
}

// Lines of a text, each behind a prefix.
void add_lines(std::string_view lines, std::string_view first, std::string_view prefix, std::string& text) {
  for (bool is_first = true; !lines.empty(); is_first = false) {
    const std::size_t end = lines.find('\n');
    text.append(is_first ? first : prefix).append(lines.substr(0, end)).append("\n");
    lines.remove_prefix(end == std::string_view::npos ? lines.size() : end + 1);
  }
}

}  // namespace

std::string heading(const OptionGroup& group) {
  std::string text = group.title;
  text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string explain(const OptionRow& row) {
  std::string text = row.help;
  if (row.kind == ValueKind::number || row.kind == ValueKind::integer) {
    // A limit that nobody meets says nothing.
    const bool open = row.max >= kNoLimit;
    if (!open || row.min > -kNoLimit) {
      text.append(text.empty() ? "" : ", ").append(number_text(row.min));
      if (!open) text.append(" to ").append(number_text(row.max));
      if (row.unit != nullptr) text.append(" ").append(row.unit);
      if (open) text += " or more";
    }
  }
  if (row.initial != nullptr) text.append(" (").append(row.initial).append(")");
  return text;
}

std::string help_text(const CommandSpec& spec) {
  std::string text;
  const std::string name = std::string(spec.name) + " ";
  add_lines(spec.usage, "usage: " + name, "       " + name, text);
  text += '\n';
  for (std::string_view rest = spec.about; !rest.empty();) {
    const std::size_t end = rest.find("\n\n");
    add_wrapped(rest.substr(0, end), 0, text);
    text += '\n';
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 2);
  }
  for (const OptionPart& part : spec.parts) {
    for (const OptionGroup& group : part) {
      text.append(heading(group)).append(":\n");
      for (const OptionRow& row : group.rows) add_option(row, text);
      text += '\n';
    }
  }
  add_option(kHelpRow, text);
  text += "\nExamples:\n";
  add_lines(spec.examples, "  ", "  ", text);
  text += "\nExit code: 0 done, 1 a file or the machine is not as it must be, 2 the command line is wrong.\n";
  return text;
}

}  // namespace karst::app
