// SPDX-License-Identifier: MIT
#include "tests/support/loaded_parts.h"

#include <cstdlib>

namespace karst::test {
namespace {

Config config_of(const TestWorld& world, std::uint32_t detail_pages, std::uint32_t max_views) {
  const WorldInfo info = world.info();
  Config config = World::config_for(info, info.level, detail_pages);
  config.max_views = max_views;
  return config;
}

}  // namespace

LoadedParts::LoadedParts(const Config& config) : memory_(terrain_budget(config).cpu_bytes()) {
  if (!create(config, memory_.bytes()).ok()) std::abort();
}

LoadedParts::LoadedParts(const TestWorld& shape, std::uint32_t detail_pages, std::uint32_t max_views)
    : LoadedParts(config_of(shape, detail_pages, max_views)) {
  file_ = shape.file();
  if (!load(file_).ok()) std::abort();
}

int LoadedParts::generate(bool ahead, int most) {
  int made = 0;
  PatchUpload upload;
  Status status;
  while (made < most && residency.generate_next(ahead, upload, status)) ++made;
  if (!status.ok()) std::abort();
  return made;
}

}  // namespace karst::test
