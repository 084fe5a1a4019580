// SPDX-License-Identifier: MIT
// TARGET [--as-they-are] FILE|FOLDER...: runs a target over files without libFuzzer: each as it is, and
// unless told otherwise, cut everywhere and with each byte changed in turn, up to kMostRuns a file.
#include "tests/fuzz/run/fuzz_target.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace {

constexpr std::size_t kMostRuns = 2'000;

std::size_t replay(const std::filesystem::path& path, bool damage) {
  std::ifstream file(path, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::byte> bytes(text.size());
  std::copy_n(std::as_bytes(std::span(text)).begin(), text.size(), bytes.begin());
  karst::fuzz_one(bytes);
  if (!damage || bytes.empty()) return 1;
  const std::size_t step = 1 + 2 * bytes.size() / kMostRuns;
  std::size_t runs = 1;
  for (std::size_t at = 0; at < bytes.size(); at += step, runs += 2) {
    // Exactly as long, so that sanitizers see what reads on.
    karst::fuzz_one(std::vector<std::byte>(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(at)));
    const std::byte kept = bytes[at];
    bytes[at] ^= std::byte{static_cast<unsigned char>(1u << at % 8)};
    karst::fuzz_one(bytes);
    bytes[at] = kept;
  }
  return runs;
}

}  // namespace

int main(int count, char** words) {
  const std::span<char* const> all(words, static_cast<std::size_t>(count));
  karst::start_target(all);
  std::vector<std::filesystem::path> files;
  bool damage = true;
  for (const std::string word : all.subspan(1)) {
    if (word == "--as-they-are") {
      damage = false;
    } else if (std::filesystem::is_directory(word)) {
      for (const auto& entry : std::filesystem::directory_iterator(word)) files.push_back(entry.path());
    } else {
      files.emplace_back(word);
    }
  }
  std::sort(files.begin(), files.end());
  std::size_t runs = 0;
  for (const auto& file : files) runs += replay(file, damage);
  std::printf("%zu files, %zu runs\n", files.size(), runs);
  return files.empty() ? 1 : 0;
}
