// SPDX-License-Identifier: MIT
#include "tests/tidy/rules.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <initializer_list>
#include <regex>
#include <utility>
#include <vector>

namespace karst::tidy {
namespace {

using std::string;
using std::string_view;

bool one_of(string_view word, std::initializer_list<string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

string_view file_name(string_view path) {
  return path.substr(path.rfind('/') + 1);
}

// ".cpp" of "a/b.cpp"; empty for names without a dot or with a leading one only.
string_view extension(string_view path) {
  const string_view name = file_name(path);
  const std::size_t dot = name.rfind('.');
  return dot == string_view::npos || dot == 0 ? string_view{} : name.substr(dot);
}

// The first n folders of a path: folders("terrain/base/a.h", 2) is "terrain/base".
string_view folders(string_view path, int n) {
  std::size_t end = 0;
  for (int i = 0; i < n; ++i) {
    const std::size_t slash = path.find('/', i == 0 ? 0 : end + 1);
    if (slash == string_view::npos) break;
    end = slash;
  }
  return path.substr(0, end);
}

template <class Visit>
void for_each_line(string_view text, Visit visit) {
  int number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    visit(number, text.substr(at, end - at));
    at = end + 1;
  }
}

// Characters, not bytes: continuation bytes of UTF-8 take no column.
int columns(string_view line) {
  return static_cast<int>(std::count_if(
      line.begin(), line.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }));
}

bool is_cpp(string_view path) {
  return one_of(extension(path), {".h", ".cpp"});
}
bool is_shader(string_view path) {
  return one_of(extension(path), {".glsl", ".vert", ".frag"});
}
bool is_script(string_view path) {
  return path == "dev" || path == ".ci/run" || extension(path) == ".sh";
}
bool is_cmake(string_view path) {
  const string_view name = file_name(path);
  return name == "CMakeLists.txt" || extension(path) == ".cmake" ||
         (name.size() > 9 && name.substr(name.size() - 9) == ".cmake.in");
}

// --- floors

// Folders that a folder may include from, besides itself. The deepest matching row of the including file
// counts.
struct Floor {
  string_view folder;
  std::vector<string_view> below;
};
// Folders of the core, lowest first: each includes from those before it.
constexpr string_view kCore[] = {
    "terrain/base",   "terrain/basis",      "terrain/procedural", "terrain/field",    "terrain/surface",
    "terrain/patch",  "terrain/isosurface", "terrain/measure",    "terrain/resident", "terrain/view",
    "terrain/motion", "terrain/cull",       "terrain/lod",        "terrain/ground",   "terrain/paging",
    "terrain/draw",   "terrain/nodes",      "terrain/blocks",     "terrain/regions",  "terrain/imagery",
    "terrain/shadow", "terrain/shading",    "terrain/query",      "terrain/file",     "terrain/world",
    "terrain/edit"};

std::vector<Floor> make_floors() {
  std::vector<Floor> floors = {{"include", {"karst"}}};
  std::vector<string_view> below = {"karst"};  // include/karst, as it is installed
  for (const string_view folder : kCore) {
    floors.push_back({folder, below});
    below.push_back(folder);
  }
  floors.insert(
      floors.end(),
      {
          {"gles_shaders", {}},
          {"renderer", {"karst", "terrain", "gles_shaders"}},
          {"platform/base", {"karst"}},
          {"platform", {"karst"}},
          {"boards", {"karst", "platform/base"}},
          {"etc2", {"karst", "terrain"}},
          {"tiles", {"karst", "terrain"}},
          {"app/files", {"karst", "platform/base"}},
          {"app/common", {"karst", "platform"}},
          {"app/json", {"karst", "platform/base"}},
          {"app/command_line", {"karst", "app/common", "platform/base"}},
          {"scene/world", {"karst", "terrain", "tiles", "renderer/input"}},
          {"scene", {"karst", "terrain", "tiles", "renderer", "gles_shaders"}},
          {"app", {"karst", "platform", "boards"}},
          {"ig/cigi", {}},
          {"ig", {"karst", "platform", "boards", "app"}},
          {"bake",
           {"karst", "terrain", "tiles", "etc2", "app/common", "app/files", "app/json", "app/command_line",
            "platform/base"}},
          {"bench", {"karst", "terrain", "tiles", "renderer", "scene", "platform", "boards", "etc2", "app"}},
          {"tests",
           {"karst", "terrain", "renderer", "gles_shaders", "scene", "platform", "boards", "etc2", "tiles",
            "app", "bake", "bench", "ig"}},
      });
  return floors;
}
const std::vector<Floor> kFloors = make_floors();

bool inside(string_view path, string_view folder) {
  return path.size() > folder.size() && path.substr(0, folder.size()) == folder && path[folder.size()] == '/';
}

const Floor* floor_of(string_view path) {
  for (const Floor& floor : kFloors) {
    if (inside(path, floor.folder)) return &floor;
  }
  return nullptr;
}

bool may_include(const Floor& floor, string_view header) {
  if (inside(header, floor.folder)) return true;
  return std::any_of(floor.below.begin(), floor.below.end(),
                     [&](string_view folder) { return inside(header, folder); });
}

// Why a header in angle brackets must not be included from a file; empty where it may.
string_view angle_problem(string_view path, string_view header) {
  const bool standard = header.find_first_of("./") == string_view::npos;
  if (inside(path, "include") && !standard) return "public headers need the standard library only";
  if (inside(path, "terrain")) {
    if (one_of(header, {"cstdio", "filesystem", "fstream", "iostream", "ostream", "istream", "sstream"})) {
      return "the core does no I/O";
    }
    const bool intrinsics = path == "terrain/base/simd.h" && one_of(header, {"emmintrin.h", "arm_neon.h"});
    if (!standard && !inside(header, "glm") && !intrinsics)
      return "the core includes GLM and the standard library only";
  }
  if (inside(header, "OpenImageIO") && !inside(path, "bake") && !inside(path, "tests")) {
    return "OpenImageIO is for karst-bake and tests only";
  }
  const bool gdal = header.starts_with("gdal") || header.starts_with("ogr_") || header.starts_with("cpl_");
  if (gdal && !inside(path, "bake") && !inside(path, "tests")) return "GDAL is for karst-bake and tests only";
  if (inside(header, "EGL") && inside(path, "renderer")) return "EGL belongs to platform";
  if ((inside(header, "GLES3") || inside(header, "GLES2")) && inside(path, "platform"))
    return "GL belongs to renderer";
  return {};
}

// The header of an #include line with its opening bracket or quote, like `<vector` or `"a/b.h`; empty for
// other lines.
string_view included_header(string_view line) {
  const std::size_t hash = line.find_first_not_of(' ');
  if (hash == string_view::npos || line[hash] != '#') return {};
  const std::size_t word = line.find_first_not_of(' ', hash + 1);
  constexpr string_view kInclude = "include";
  if (word == string_view::npos || line.substr(word, kInclude.size()) != kInclude) return {};
  const std::size_t open = line.find_first_of("<\"", word);
  if (open == string_view::npos) return {};
  const std::size_t close = line.find_first_of(">\"", open + 1);
  return close == string_view::npos ? string_view{} : line.substr(open, close - open);
}

}  // namespace

void check_known(const Source& source, Findings& out) {
  const string_view path = source.path;
  const string_view top = folders(path, 1);
  const string_view ext = extension(path);
  bool known = false;
  if (top.empty()) {
    known = one_of(path, {".clang-format", ".clang-tidy", ".gitattributes", ".gitignore", "CMakeLists.txt",
                          "CMakePresets.json", "CHANGELOG.md", "LICENSE", "README.md", "dev"});
  } else if (top == ".ci") {
    known = path == ".ci/run";
  } else if (one_of(top, {"include", "terrain", "platform", "renderer", "scene", "app", "bake", "bench",
                          "etc2", "tiles", "ig"})) {
    known = is_cpp(path) || is_cmake(path);
    known = known || (top == "app" && is_shader(path));  // of hosts, which karst's are not
    if (top == "terrain" && !is_cmake(path)) known = known && floor_of(path) != nullptr;
  } else if (top == "examples") {
    known = is_cpp(path) || is_cmake(path);
  } else if (top == "package") {
    known = is_cmake(path) || ext == ".in";
  } else if (top == "gles_shaders") {
    known = is_shader(path) || is_cmake(path) || one_of(ext, {".def", ".h"});
  } else if (top == "boards") {
    known = is_cpp(path) || is_cmake(path) || one_of(ext, {".board", ".md", ".sh", ".service", ".yml"});
  } else if (top == "docs") {
    known = one_of(ext, {".md", ".png", ".svg", ".csv"}) ||
            (folders(path, 2) == "docs/devices" && ext == ".json");
  } else if (top == "tests") {
    known = is_cpp(path) || is_cmake(path) || one_of(ext, {".json", ".md", ".plan", ".png", ".py", ".sh"});
  }
  const bool plain = std::all_of(path.begin(), path.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           string_view("._-/").find(c) != string_view::npos;
  });
  if (!known || !plain)
    out.push_back({source.path, 0, "does not belong here (tests/tidy/rules.cpp, check_known)"});
}

bool is_text(string_view path) {
  return !one_of(extension(path), {".png", ".svg", ".csv"});  // pictures and tables are made by programs
}

void check_text(const Source& source, Findings& out) {
  const bool markdown = extension(source.path) == ".md";
  const bool json = extension(source.path) == ".json";
  int lines = 0;
  for_each_line(source.text, [&](int number, string_view line) {
    lines = number;
    const bool table = markdown && !line.empty() && line.front() == '|';
    if (columns(line) > kMaxColumns && !table && !json)
      out.push_back({source.path, number, "line is too long"});
    if (line.find('\t') != string_view::npos) out.push_back({source.path, number, "tab"});
    if (line.find('\r') != string_view::npos) {
      out.push_back({source.path, number, "carriage return"});
    } else if (!line.empty() && line.back() == ' ') {
      out.push_back({source.path, number, "blank at the end of the line"});
    }
  });
  if (lines > kMaxLines && !json)
    out.push_back({source.path, 0, "file is too long: " + std::to_string(lines) + " lines"});
  if (source.text.empty() || source.text.back() != '\n') {
    out.push_back({source.path, lines, "no newline at the end of the file"});
  }
}

void check_licence(const Source& source, Findings& out) {
  const bool slashes = is_cpp(source.path) || is_shader(source.path) || extension(source.path) == ".def";
  const bool script = is_script(source.path);
  if (!slashes && !script && !is_cmake(source.path)) return;
  const string wanted = string(slashes ? "//" : "#") + " SPDX-License-Identifier: MIT";
  // A shader's #version and a script's #! must stand on the first line.
  const bool shader_stage = is_shader(source.path) && source.text.substr(0, 9) == "#version ";
  const int place = script || shader_stage ? 2 : 1;
  bool found = false;
  for_each_line(source.text,
                [&](int number, string_view line) { found = found || (number == place && line == wanted); });
  if (!found) out.push_back({source.path, place, "expected: " + wanted});
}

void check_header_guard(const Source& source, Findings& out) {
  if (extension(source.path) != ".h") return;
  int guards = 0;
  for_each_line(source.text, [&](int, string_view line) { guards += line == "#pragma once" ? 1 : 0; });
  if (guards != 1) out.push_back({source.path, 0, "expected one #pragma once"});
}

void check_includes(const Source& source, Findings& out) {
  if (!is_cpp(source.path)) return;
  if (inside(source.path, "examples")) {  // they stand for programs outside: installed headers, and their own
    for_each_line(source.text, [&](int number, string_view line) {
      const string_view include = included_header(line);
      if (include.empty() || (include.front() == '"' ? include.find('/') == string_view::npos
                                                     : floor_of(include.substr(1)) == nullptr)) {
        return;
      }
      out.push_back({source.path, number, string(include.substr(1)) + ": not installed, and not beside it"});
    });
    return;
  }
  const Floor* floor = floor_of(source.path);
  if (floor == nullptr) return;  // check_known reports it
  for_each_line(source.text, [&](int number, string_view line) {
    const string_view include = included_header(line);
    if (include.empty()) return;
    const string_view header = include.substr(1);
    if (include.front() == '<') {
      const string_view problem = angle_problem(source.path, header);
      if (!problem.empty()) out.push_back({source.path, number, string(header) + ": " + string(problem)});
    } else if (header.find("..") != string_view::npos ||
               (floor_of(header) == nullptr && !inside(header, "karst"))) {
      out.push_back(
          {source.path, number, string(header) + ": name karst's headers from the repository's root"});
    } else if (!may_include(*floor, header)) {
      out.push_back(
          {source.path, number, string(header) + ": " + string(floor->folder) + " includes downwards only"});
    }
  });
}

void check_own_header(const Source& source, const std::function<bool(const string&)>& exists, Findings& out) {
  if (extension(source.path) != ".cpp") return;
  const string own = source.path.substr(0, source.path.size() - string_view("cpp").size()) + "h";
  if (!exists(own)) return;
  bool first = true;
  for_each_line(source.text, [&](int number, string_view line) {
    const string_view include = included_header(line);
    if (include.empty() || !first) return;
    first = false;
    // Examples are programs of their own, which know no repository.
    const string_view header = include.substr(1);
    const bool found = header == own || (inside(own, "examples") && header == file_name(own));
    if (include.front() != '"' || !found) {
      out.push_back({source.path, number, "expected first: " + own});
    }
  });
  if (first) out.push_back({source.path, 0, "does not include " + own});
}

void check_words(const Source& source, Findings& out) {
  // Spelled in halves, so that this file passes its own rules.
  static const string kMarks[] = {string("TO") + "DO", string("FIX") + "ME", string("XX") + "X",
                                  string("HA") + "CK"};
  static const string kRoots[] = {string("/wo") + "rk", string("/tm") + "p", string("/ho") + "me",
                                  string("/ro") + "ot", string("/mn") + "t"};
  const auto word_character = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
  };
  const auto has_word = [&](string_view line, string_view word) {
    for (std::size_t at = line.find(word); at != string_view::npos; at = line.find(word, at + 1)) {
      const char before = at == 0 ? ' ' : line[at - 1];
      const std::size_t end = at + word.size();
      const char after = end == line.size() ? ' ' : line[end];
      // "a/work" and "../work" are relative and fine.
      if (!word_character(before) && before != '.' && !word_character(after)) return true;
    }
    return false;
  };
  for_each_line(source.text, [&](int number, string_view line) {
    for (const string& mark : kMarks) {
      if (has_word(line, mark)) out.push_back({source.path, number, "unfinished: " + mark});
    }
    for (const string& root : kRoots) {
      if (has_word(line, root)) out.push_back({source.path, number, "path of one machine: " + root});
    }
  });
}

void check_links(const Source& source, const std::function<bool(const string&)>& exists, Findings& out) {
  if (extension(source.path) != ".md") return;
  for_each_line(source.text, [&](int number, string_view line) {
    for (std::size_t at = line.find("]("); at != string_view::npos; at = line.find("](", at + 1)) {
      const std::size_t end = line.find(')', at);
      if (end == string_view::npos) return;
      string_view target = line.substr(at + 2, end - at - 2);
      if (target.find("://") != string_view::npos) continue;
      target = target.substr(0, target.find('#'));
      if (target.empty()) continue;
      const std::filesystem::path folder = std::filesystem::path(source.path).parent_path();
      const string resolved = (folder / target).lexically_normal().generic_string();
      if (!exists(resolved)) out.push_back({source.path, number, "link to nothing: " + resolved});
    }
  });
}

namespace {

const std::regex kNamedPath(
    "([A-Za-z0-9_.-]+/)*([A-Za-z0-9_-]+\\.(h|cpp|glsl|vert|frag|def|cmake|sh|py|yml|txt|service|md)"
    "|[a-z][a-z0-9_-]*/)");
const std::regex kNamedIdentifier("[A-Za-z_][A-Za-z0-9_]*(::[A-Za-z_][A-Za-z0-9_]*)*(\\(.*\\))?");

// Of what is not the project's: built, a user's, or a stand-in.
bool is_elsewhere(const string& path) {
  for (const char* top : {"build/", "out/", "../"}) {
    if (inside(path, string(top).substr(0, string(top).size() - 1))) return true;
  }
  return path.find("NAME") != string::npos || path.find("FILE") != string::npos;
}

}  // namespace

void check_names(const Source& source, const std::function<bool(const string&)>& has_path,
                 const std::function<bool(const string&)>& has_word, Findings& out) {
  if (extension(source.path) != ".md") return;
  const auto check_path = [&](int number, const string& word) {
    if (!std::regex_match(word, kNamedPath) || is_elsewhere(word) || has_path(word)) return;
    out.push_back({source.path, number, "names what is not there: " + word});
  };
  const std::regex word("[^\\s\"'=:,;()]+");
  const auto check_words_of = [&](int number, const string& text) {
    for (std::sregex_iterator w(text.begin(), text.end(), word), end; w != end; ++w)
      check_path(number, w->str());
  };
  const std::regex quoted("`([^`]+)`");
  const std::regex part("[A-Za-z_][A-Za-z0-9_]*");
  bool fenced = false;
  for_each_line(source.text, [&](int number, string_view view) {
    const string line(view);
    if (line.rfind("```", 0) == 0) fenced = !fenced;
    if (fenced) return;
    if (line.rfind("    ", 0) == 0) check_words_of(number, line);
    for (std::sregex_iterator q(line.begin(), line.end(), quoted), end; q != end; ++q) {
      const string span = (*q)[1].str();
      check_words_of(number, span);
      if (!std::regex_match(span, kNamedIdentifier) || span.find_first_of("_:(") == string::npos) continue;
      const string name = span.substr(0, span.find('('));
      for (std::sregex_iterator p(name.begin(), name.end(), part); p != end; ++p) {
        if (!has_word(p->str()))
          out.push_back({source.path, number, "names what is in no source: " + p->str()});
      }
    }
  });
}

}  // namespace karst::tidy
