// SPDX-License-Identifier: MIT
// Tests on a machine without a build tree (tests/device): what they need from it is where the environment
// says.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/process.h"

// A build for another processor has no karst-bake.
#ifndef KARST_BAKE_PATH
#define KARST_BAKE_PATH ""
#endif

namespace karst::test {

// The value of an environment variable, or, where it is not set, the build's own path.
inline std::string path_from(const char* variable, const char* built) {
  const char* const value = std::getenv(variable);
  return value != nullptr ? value : built;
}

// Where KARST_WORLDS names a folder of baked worlds, NAME.karst of that; else a world that karst-bake (bake:
// its path) makes of these words in the folder. empty: neither is there, and missing says what.
struct BakedWorld {
  std::string path;
  std::string missing;
};
inline BakedWorld baked_world(const Folder& folder, const std::string& name, const std::string& bake,
                              std::vector<std::string> words) {
  const std::string path = path_from("KARST_WORLDS", folder.path("").c_str()) + "/" + name + ".karst";
  if (std::getenv("KARST_WORLDS") != nullptr)
    return std::filesystem::exists(path) ? BakedWorld{path, ""}
                                         : BakedWorld{"", name + ".karst is not there"};
  if (bake.empty()) return {"", "karst-bake is not there"};
  words.insert(words.end(), {"--quiet", "-o", path});
  const ProcessResult baked = run_process(bake, words);
  if (baked.code != 0) throw std::runtime_error("karst-bake: " + baked.err);
  return {path, ""};
}

}  // namespace karst::test
