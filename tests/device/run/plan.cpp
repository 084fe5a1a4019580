// SPDX-License-Identifier: MIT
#include "tests/device/run/plan.h"

#include <iterator>

namespace karst::device {
namespace {

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(' ', at)) != std::string_view::npos;) {
    const std::size_t end = std::min(line.find(' ', at), line.size());
    words.emplace_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

Error parse_line(std::string_view line, std::vector<Part>& parts) {
  const std::vector<std::string> words = words_of(line.substr(0, line.find('#')));
  if (words.empty()) return {};
  if (words.size() < 4 || words[2] != ":") return "not of the form KIND NAME : WORDS";
  Part part;
  std::size_t kind = 0;
  while (kind < std::size(kPartKinds) && words[0] != kPartKinds[kind]) ++kind;
  if (kind == std::size(kPartKinds)) return "'" + words[0] + "' is no kind of part";
  part.kind = static_cast<PartKind>(kind);
  part.name = words[1];
  part.words.assign(words.begin() + 3, words.end());
  for (const Part& other : parts) {
    if (other.kind == part.kind && other.name == part.name)
      return "there is another " + words[0] + " '" + part.name + "'";
  }
  parts.push_back(std::move(part));
  return {};
}

}  // namespace

Error parse_plan(std::string_view text, const std::string& name, std::vector<Part>& parts) {
  parts.clear();
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    if (const Error error = parse_line(text.substr(0, end), parts); !error.ok())
      return name + ", line " + std::to_string(number) + ": " + error.text();
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts.empty() ? Error(name + ": has no parts") : Error();
}

}  // namespace karst::device
