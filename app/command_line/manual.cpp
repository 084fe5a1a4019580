// SPDX-License-Identifier: MIT
#include "app/command_line/manual.h"

#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <string_view>

#include "app/command_line/help.h"
#include "app/common/arguments.h"

namespace karst::app {
namespace {

void add(std::initializer_list<std::string_view> parts, std::string& text) {
  for (const std::string_view part : parts) text += part;
}

// Text as troff prints it literally.
std::string roff(std::string_view text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
    line_begins = c == '\n';
  }
  return result;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return text;
}

std::string page_name(const CommandSpec& command) {
  std::string name = command.name;
  std::replace(name.begin(), name.end(), ' ', '-');
  return name;
}

void add_head(const std::string& page, const char* brief, std::string& text) {
  text += ".\\\" Made from the program's table of options.\n";
  add({".TH ", upper(roff(page)), " 1 \"\" \"karst " KARST_VERSION "\" \"karst\"\n"}, text);
  add({".SH NAME\n", roff(page), " \\- ", roff(brief), "\n"}, text);
}

// Paragraphs with an empty line between them.
void add_paragraphs(std::string_view paragraphs, std::string& text) {
  while (!paragraphs.empty()) {
    const std::size_t end = paragraphs.find("\n\n");
    add({".PP\n", roff(paragraphs.substr(0, end)), "\n"}, text);
    paragraphs.remove_prefix(end == std::string_view::npos ? paragraphs.size() : end + 2);
  }
}

void add_option(const OptionRow& row, std::string& text) {
  text += ".TP\n";
  if (row.letter != 0) add({"\\fB\\-", {&row.letter, 1}, "\\fR, "}, text);
  add({"\\fB\\-\\-", roff(row.name), "\\fR"}, text);
  if (row.value != nullptr) add({" \\fI", roff(row.value), "\\fR"}, text);
  add({"\n", roff(explain(row)), "\n"}, text);
}

void add_exit_codes(std::string& text) {
  text += ".SH EXIT STATUS\n";
  text +=
      "0: done. 1: a file, a picture or the machine is not as it must be; one line on standard error says\n";
  text += "which. 2: the command line is wrong.\n";
}

// Words that complete a value; empty where only the user knows.
void add_completions(const OptionRow& row, std::string& text) {
  const std::string_view value = row.value != nullptr ? row.value : "";
  if (row.words != nullptr) {
    add({"COMPREPLY=($(compgen -W '", row.words, "' -- \"$cur\"))"}, text);
  } else if (value == "BOARD") {
    text +=
        "compopt -o filenames; COMPREPLY=($(compgen -W \"$(karst budget --list-boards 2>/dev/null)\" -- "
        "\"$cur\") $(compgen -f -- \"$cur\"))";
  } else if (row.kind == ValueKind::file) {
    text += "compopt -o filenames; COMPREPLY=($(compgen -f -- \"$cur\"))";
  } else {
    text += "COMPREPLY=()";
  }
}

void add_command_cases(const CommandSpec& command, std::string_view indent, std::string& text) {
  std::string names;
  add({indent, "case \"$prev\" in\n"}, text);
  for_each_option(command, [&](const OptionRow& row) {
    add({names.empty() ? "--" : " --", row.name}, names);
    if (row.kind == ValueKind::flag) return;
    add({indent, "  --", row.name}, text);
    if (row.letter != 0) add({"|-", {&row.letter, 1}}, text);
    text += ") ";
    add_completions(row, text);
    text += "; return ;;\n";
  });
  add({indent, "esac\n", indent, "options='", names, "'\n"}, text);
}

// "view" of "karst view".
std::string_view word_of(const ProgramSpec& program, const CommandSpec& command) {
  return std::string_view(command.name).substr(std::string_view(program.name).size() + 1);
}

}  // namespace

std::string man_page(const ProgramSpec& program, const CommandSpec& command) {
  std::string text;
  add_head(page_name(command), command.brief, text);
  text += ".SH SYNOPSIS\n";
  for (std::string_view rest = command.usage; !rest.empty();) {
    const std::size_t end = rest.find('\n');
    add({"\\fB", roff(command.name), "\\fR ", roff(rest.substr(0, end)), "\n.br\n"}, text);
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  text += ".SH DESCRIPTION\n";
  add_paragraphs(command.about, text);
  text += ".SH OPTIONS\n";
  for (const OptionPart& part : command.parts) {
    for (const OptionGroup& group : part) {
      add({".SS ", roff(heading(group)), "\n"}, text);
      for (const OptionRow& row : group.rows) add_option(row, text);
    }
  }
  text += ".SS Help\n";
  add_option(kHelpRow, text);
  add({".SH EXAMPLES\n.nf\n", roff(command.examples), "\n.fi\n"}, text);
  add_exit_codes(text);
  if (program.commands.size() > 1) add({".SH SEE ALSO\n.BR ", roff(program.name), " (1)\n"}, text);
  return text;
}

std::string man_page(const ProgramSpec& program) {
  std::string text;
  add_head(program.name, program.brief, text);
  add({".SH SYNOPSIS\n\\fB", roff(program.name), "\\fR COMMAND ...\n.SH DESCRIPTION\n"}, text);
  add_paragraphs(program.about, text);
  text += ".SH COMMANDS\n";
  for (const CommandSpec* command : program.commands) {
    add({".TP\n\\fB", roff(page_name(*command)), "\\fR(1)\n", roff(command->brief), "\n"}, text);
  }
  text += ".SH OPTIONS\n.TP\n\\fB\\-\\-help\\fR\nprints the commands; behind a command, its options\n";
  text += ".TP\n\\fB\\-\\-version\\fR\nprints the version\n";
  add_exit_codes(text);
  return text;
}

std::string bash_completion(const ProgramSpec& program) {
  std::string function = program.name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string text;
  add({"# bash completion for ", program.name, ", made from its table of options.\n"}, text);
  add({"_", function, "() {\n"}, text);
  text += "  local cur=${COMP_WORDS[COMP_CWORD]} prev= options=\n";
  text += "  ((COMP_CWORD > 0)) && prev=${COMP_WORDS[COMP_CWORD-1]}\n";
  if (program.commands.size() > 1) {
    text += "  if ((COMP_CWORD == 1)); then\n    COMPREPLY=($(compgen -W '";
    for (const CommandSpec* command : program.commands) add({word_of(program, *command), " "}, text);
    text += "--help --version' -- \"$cur\"))\n    return\n  fi\n  case \"${COMP_WORDS[1]}\" in\n";
    for (const CommandSpec* command : program.commands) {
      add({"    ", word_of(program, *command), ")\n"}, text);
      add_command_cases(*command, "      ", text);
      text += "      ;;\n";
    }
    text += "  esac\n";
  } else {
    add_command_cases(*program.commands.front(), "  ", text);
  }
  text += "  if [[ $cur == -* ]]; then\n    COMPREPLY=($(compgen -W \"$options\" -- \"$cur\"))\n  else\n";
  text += "    compopt -o filenames\n    COMPREPLY=($(compgen -f -- \"$cur\"))\n  fi\n}\n";
  add({"complete -F _", function, " ", program.name, "\n"}, text);
  return text;
}

int print_manual(const ProgramSpec& program, std::span<const char* const> words) {
  std::string text;
  if (words.size() == 1 && std::string_view(words[0]) == "completion") text = bash_completion(program);
  if (words.size() == 2 && std::string_view(words[0]) == "man") {
    if (program.commands.size() > 1 && std::string_view(words[1]) == program.name) text = man_page(program);
    for (const CommandSpec* command : program.commands) {
      if (page_name(*command) == words[1]) text = man_page(program, *command);
    }
  }
  if (text.empty()) {
    print_error(program.name, "prints a page by `man NAME`, or `completion`");
    return kExitUsage;
  }
  std::fputs(text.c_str(), stdout);
  const Error error = flush_output();
  if (!error.ok()) print_error(program.name, error.text());
  return error.ok() ? kExitOk : kExitFailure;
}

}  // namespace karst::app
