// SPDX-License-Identifier: MIT
// House rules that a program can check, one function a rule. Each takes one file's path (from the
// repository's root, with '/') and text, and appends what it finds. tidy_test.cpp runs them over the
// repository and over samples that break them on purpose.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace karst::tidy {

struct Source {
  std::string path;
  std::string text;
};

struct Finding {
  std::string path;
  int line;  // from 1; 0 for the file as a whole
  std::string what;
};
using Findings = std::vector<Finding>;

// The longest line and the longest file that read well.
inline constexpr int kMaxColumns = 110;
inline constexpr int kMaxLines = 700;

// Whether a path may be in the repository at all: known folders, and in each the kinds of files that belong
// there.
void check_known(const Source& source, Findings& out);

// Whether check_text and the rest apply: everything but pictures and other binary test data.
bool is_text(std::string_view path);

// Lines of at most kMaxColumns characters, at most kMaxLines of them, no tabs, no carriage returns, no blanks
// at a line's end, a newline at the file's end. Markdown tables and JSON may have longer lines, JSON more.
void check_text(const Source& source, Findings& out);

// The licence line: first in sources, CMake files and shader parts, second after a #! or #version line.
void check_licence(const Source& source, Findings& out);

// #pragma once in headers.
void check_header_guard(const Source& source, Findings& out);

// Floors (docs/architecture.md): each folder includes from itself and from below; the core includes GLM and
// the standard library only, and no I/O.
void check_includes(const Source& source, Findings& out);

// A .cpp file that has a header of its own includes it before all else, so that every header is compiled once
// with nothing before it. exists: as of check_links.
void check_own_header(const Source& source, const std::function<bool(const std::string&)>& exists,
                      Findings& out);

// Paths of one machine, and marks of unfinished work.
void check_words(const Source& source, Findings& out);

// Relative links in Markdown. exists: whether a path from the repository's root is there.
void check_links(const Source& source, const std::function<bool(const std::string&)>& exists, Findings& out);

// What documents name: paths of the project in quoted or indented text, and quoted identifiers with an
// underscore, a scope or parentheses. has_path: whether a path, or the end of one after a '/', is there.
// has_word: whether some source contains it.
void check_names(const Source& source, const std::function<bool(const std::string&)>& has_path,
                 const std::function<bool(const std::string&)>& has_word, Findings& out);

}  // namespace karst::tidy
