// SPDX-License-Identifier: MIT
#include "tests/tidy/shape.h"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <map>
#include <set>

namespace karst::tidy {
namespace {

using std::string;
using std::string_view;

string folder_of(string_view path) {
  const std::size_t slash = path.rfind('/');
  return string(slash == string_view::npos ? string_view{} : path.substr(0, slash));
}

bool ends_with(string_view text, string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

bool is_cpp(string_view path) {
  return ends_with(path, ".h") || ends_with(path, ".cpp");
}

const Exception* find(const Exceptions& exceptions, string_view name) {
  for (const Exception& exception : exceptions) {
    if (exception.name == name) return &exception;
  }
  return nullptr;
}

void report_unneeded(const Exceptions& exceptions, const std::set<string>& used, Findings& out) {
  for (const Exception& exception : exceptions) {
    if (used.count(exception.name) == 0) {
      out.push_back({exception.name, 0, "needs no exception any more (tests/tidy/shape.cpp)"});
    }
  }
}

bool word_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

// The text without comments, literals and preprocessor lines; lines stay where they are.
string code_of(string_view text) {
  string code(text);
  const auto blank = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < std::min(to, code.size()); ++i) {
      if (code[i] != '\n') code[i] = ' ';
    }
  };
  bool line_start = true;
  for (std::size_t i = 0; i < code.size();) {
    std::size_t end = i + 1;
    const string_view rest = string_view(text).substr(i);
    if (rest.substr(0, 2) == "//" || (line_start && rest.front() == '#')) {
      end = std::min(text.find('\n', i), text.size());
      blank(i, end);
    } else if (rest.substr(0, 2) == "/*") {
      end = std::min(text.find("*/", i), text.size() - 2) + 2;
      blank(i, end);
    } else if (rest.substr(0, 3) == "R\"(") {
      end = std::min(text.find(")\"", i), text.size() - 2) + 2;
      blank(i, end);
    } else if (rest.front() == '"' || (rest.front() == '\'' && (i == 0 || !word_character(text[i - 1])))) {
      while (end < text.size() && text[end] != rest.front()) end += text[end] == '\\' ? 2u : 1u;
      ++end;
      blank(i, end);
    }
    line_start = (line_start && rest.front() == ' ') || rest.front() == '\n';
    i = end;
  }
  return code;
}

// A statement without what stands in brackets of any kind; "()" and "{}" remain where there were some.
string without_groups(string_view text) {
  string result;
  int angles = 0;
  int others = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool arrow = c == '>' && i > 0 && text[i - 1] == '-';
    const bool opens = c == '(' || c == '{' || c == '[';
    const bool closes = c == ')' || c == '}' || c == ']';
    if (others == 0 && c == '<') ++angles;
    if (angles == 0 && others == 0) result.push_back(c);
    if (opens) ++others;
    if (closes) {
      --others;
      if (angles == 0 && others == 0) result.push_back(c);
    }
    if (others == 0 && angles > 0 && c == '>' && !arrow) --angles;
  }
  return result;
}

string first_word(string_view text) {
  const std::size_t begin = text.find_first_not_of(" \n");
  if (begin == string_view::npos) return {};
  std::size_t end = begin;
  while (end < text.size() && word_character(text[end])) ++end;
  return string(text.substr(begin, end - begin));
}

// How many data members a statement of a class declares.
int members_in(string_view statement) {
  string text = without_groups(statement);
  // What access labels leave before the first member after them.
  for (const string_view label : {"public:", "private:", "protected:"}) {
    if (const std::size_t at = text.find(label); at != string::npos) text.erase(0, at + label.size());
  }
  const string word = first_word(text);
  if (word == "static" || word == "using" || word == "friend" || word == "return") return 0;
  if (text.find('(') < text.find('=')) return 0;  // a function
  int members = 0;
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    string declarator = text.substr(at, comma - at);
    declarator = declarator.substr(0, declarator.find_first_of("={["));
    while (!declarator.empty() && !word_character(declarator.back())) declarator.pop_back();
    members += !declarator.empty() && declarator.back() == '_' ? 1 : 0;
    at = comma + 1;
  }
  return members;
}

// The name of the class that a statement before '{' opens; empty where it opens none.
string class_opened(string_view statement) {
  string text = without_groups(statement);
  for (const string_view label : {"public:", "private:", "protected:"}) {
    if (const std::size_t at = text.find(label); at != string::npos) text.erase(0, at + label.size());
  }
  if (first_word(text) == "template") text.erase(0, text.find("template") + 8);
  const string kind = first_word(text);
  if (kind != "class" && kind != "struct") return {};
  if (text.find('(') != string::npos || text.find('=') != string::npos) return {};
  text = text.substr(text.find(kind) + kind.size());
  while (text.find("[]") != string::npos) text.erase(text.find("[]"), 2);
  return first_word(text);
}

struct Scope {
  int found = -1;  // index of its ClassSize; -1: no class
  bool initialiser = false;
  string statement;
};

// Folders that the folder includes from, each with one include that does so.
using Graph = std::map<string, std::map<string, Finding>>;

Graph folder_graph(const std::vector<Source>& sources) {
  Graph graph;
  for (const Source& source : sources) {
    if (!is_cpp(source.path)) continue;
    const string from = folder_of(source.path);
    int number = 0;
    for (std::size_t at = 0; at < source.text.size();) {
      const std::size_t end = std::min(source.text.find('\n', at), source.text.size());
      const string_view line = string_view(source.text).substr(at, end - at);
      ++number;
      at = end + 1;
      constexpr string_view kInclude = "#include \"";
      if (line.substr(0, kInclude.size()) != kInclude) continue;
      const string_view header = line.substr(kInclude.size(), line.rfind('"') - kInclude.size());
      const string to = folder_of(header);
      if (!to.empty() && to != from) graph[from].insert({to, {source.path, number, string(header)}});
    }
  }
  return graph;
}

void reach(const Graph& graph, const string& from, std::set<string>& seen) {
  const auto edges = graph.find(from);
  if (edges == graph.end()) return;
  for (const auto& [to, finding] : edges->second) {
    if (seen.insert(to).second) reach(graph, to, seen);
  }
}

}  // namespace

void check_folder_sizes(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out) {
  std::map<string, std::size_t> sizes;
  for (const Source& source : sources) {
    if (!ends_with(source.path, "CMakeLists.txt")) ++sizes[folder_of(source.path)];
  }
  std::set<string> used;
  for (const auto& [folder, size] : sizes) {
    if (size <= kMostFiles) continue;
    used.insert(folder);
    const Exception* exception = find(exceptions, folder);
    if (exception == nullptr || size > exception->most) {
      out.push_back({folder, 0, std::to_string(size) + " files"});
    }
  }
  report_unneeded(exceptions, used, out);
}

void check_circles(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out) {
  const Graph graph = folder_graph(sources);
  std::map<string, std::set<string>> reached;
  for (const auto& [folder, edges] : graph) reach(graph, folder, reached[folder]);
  std::set<string> used;
  for (const auto& [folder, edges] : graph) {
    for (const auto& [to, finding] : edges) {
      if (reached[to].count(folder) == 0) continue;
      const string name = std::min(folder, to) + " - " + std::max(folder, to);
      used.insert(name);
      if (find(exceptions, name) == nullptr) {
        out.push_back({finding.path, finding.line, finding.what + ": includes " + folder + " in turn"});
      }
    }
  }
  report_unneeded(exceptions, used, out);
}

std::vector<ClassSize> class_sizes(const Source& source) {
  std::vector<ClassSize> result;
  const string code = code_of(source.text);
  std::vector<Scope> scopes(1);
  int line = 1;
  for (const char c : code) {
    if (c == '\n') ++line;
    Scope& scope = scopes.back();
    if (c == '{') {
      const string name = class_opened(scope.statement);
      const string outline = without_groups(scope.statement);
      Scope inner;
      if (!name.empty()) {
        inner.found = static_cast<int>(result.size());
        result.push_back({source.path, 0, name, 0});
      } else if (outline.find('(') == string::npos) {
        inner.initialiser = scope.found >= 0;  // of a member
      } else {
        // Of a member in a constructor's list, or a function's body.
        const std::size_t last = outline.find_last_not_of(" \n");
        inner.initialiser = outline.find(" : ") != string::npos && outline[last] == '_';
      }
      scopes.push_back(std::move(inner));
    } else if (c == '}') {
      if (scopes.size() == 1) continue;  // not C++ as it is known here
      const bool initialiser = scopes.back().initialiser;
      const bool is_class = scopes.back().found >= 0;
      scopes.pop_back();
      if (initialiser) {
        scopes.back().statement += "{}";
      } else if (is_class) {
        scopes.back().statement = "class ";  // a declarator may follow
      } else {
        scopes.back().statement.clear();
      }
    } else if (c == ';') {
      if (scope.found >= 0) {
        ClassSize& size = result[static_cast<std::size_t>(scope.found)];
        const int members = members_in(scope.statement);
        if (members > 0 && size.members == 0) size.line = line;
        size.members += members;
      }
      scope.statement.clear();
    } else {
      scope.statement.push_back(c);
    }
  }
  std::erase_if(result, [](const ClassSize& size) { return size.members == 0; });
  return result;
}

void check_class_sizes(const std::vector<Source>& sources, const Exceptions& exceptions, Findings& out) {
  std::set<string> used;
  for (const Source& source : sources) {
    if (!is_cpp(source.path)) continue;
    for (const ClassSize& size : class_sizes(source)) {
      if (size.members <= kMostMembers) continue;
      used.insert(size.name);
      const Exception* exception = find(exceptions, size.name);
      if (exception == nullptr || static_cast<std::size_t>(size.members) > exception->most) {
        out.push_back({size.path, size.line, size.name + ": " + std::to_string(size.members) + " members"});
      }
    }
  }
  report_unneeded(exceptions, used, out);
}

const Exceptions& large_folders() {
  constexpr std::size_t kAny = SIZE_MAX;
  static const Exceptions kList = {
      {"bench/suites", 18, "a suite is two or three files"},
      {"docs", kAny, "a page a subject"},
      {"docs/images", kAny, "pictures"},
      {"gles_shaders", kAny, "a file a shader; #include in GLSL takes plain names"},
      {"terrain/patch", 13, "one stage, a pair of files a step"},
      {"terrain/query", 13, "one subject, a pair of files a step"},
      {"tests/bake", kAny, "a file a subject that is tested"},
      {"tests/gl", kAny, "a file a subject that is tested"},
      {"tests/golden/images", kAny, "a picture a view"},
      {"tests/library", kAny, "a file a subject that is tested"},
      {"tests/support", kAny, "a pair of files a helper"},
      {"tests/unit", kAny, "a file a subject that is tested"},
  };
  return kList;
}

const Exceptions& circles() {
  static const Exceptions kList = {};
  return kList;
}

const Exceptions& large_classes() {
  static const Exceptions kList = {};
  return kList;
}

}  // namespace karst::tidy
