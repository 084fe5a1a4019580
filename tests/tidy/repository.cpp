// SPDX-License-Identifier: MIT
#include "tests/tidy/repository.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

namespace karst::tidy {

namespace fs = std::filesystem;

std::vector<Source> repository() {
  std::vector<Source> sources;
  const fs::path root(KARST_SOURCE_DIR);
  for (auto entry = fs::recursive_directory_iterator(root); entry != fs::recursive_directory_iterator();
       ++entry) {
    const std::string path = entry->path().lexically_relative(root).generic_string();
    const bool ignored = path == ".git" || path == "build" || path == "out" || path == ".cache";
    if (ignored) entry.disable_recursion_pending();
    if (ignored || !entry->is_regular_file()) continue;
    std::ifstream file(entry->path(), std::ios::binary);
    sources.push_back({path, std::string(std::istreambuf_iterator<char>(file), {})});
  }
  std::sort(sources.begin(), sources.end(), [](const Source& a, const Source& b) { return a.path < b.path; });
  return sources;
}

std::string listing(const Findings& findings) {
  std::ostringstream text;
  for (const Finding& finding : findings)
    text << finding.path << ':' << finding.line << ": " << finding.what << '\n';
  return text.str();
}

}  // namespace karst::tidy
