// SPDX-License-Identifier: MIT
#include "terrain/field/sky_atlas.h"

#include <algorithm>
#include <cstdint>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// One above the other.
void stack(SkyAtlas& atlas) {
  atlas.cells = glm::ivec3(0);
  for (std::size_t n = 0; n < atlas.count; ++n) {
    SkyAtlas::Place& place = atlas.places[n];
    place.first = atlas.cells.y;
    atlas.cells.x = std::max(atlas.cells.x, place.grid.cells.x);
    atlas.cells.z = std::max(atlas.cells.z, place.grid.cells.z);
    atlas.cells.y += place.grid.cells.y;
  }
}

bool fits(const SkyAtlas& atlas) {
  const SkyGrid all{atlas.cells, 0};
  return atlas.cells.y <= SkyVisibility::kMostSide && all.bytes() <= SkyAtlas::kMostBytes;
}

}  // namespace

SkyAtlas SkyAtlas::of(std::span<const SkyBox> boxes, std::size_t words) {
  KARST_ASSERT(!boxes.empty() && boxes.size() <= kMostRegions);
  SkyAtlas atlas;
  atlas.count = boxes.size();
  const std::size_t all = word_count(boxes);
  for (std::size_t n = 0; n < boxes.size(); ++n) {
    const std::size_t own = SkyVisibility::word_count(boxes[n].extent);
    Place& place = atlas.places[n];
    place.box = boxes[n];
    place.words = words >= all
                      ? own
                      : static_cast<std::size_t>(static_cast<double>(words) * static_cast<double>(own) /
                                                 static_cast<double>(all));
    if (boxes.size() == 1) place.words = std::min(words, own);
    place.grid = SkyVisibility::grid_for(boxes[n].extent, place.words);
  }
  stack(atlas);
  // The largest one first.
  while (atlas.count > 1 && !fits(atlas)) {
    Place* most = &atlas.places[0];
    for (Place& place : std::span(atlas.places).first(atlas.count)) {
      if (place.grid.cells.y > most->grid.cells.y) most = &place;
    }
    if (most->grid.cell_log2 >= kMaxDepth) break;
    most->grid = SkyVisibility::grid_for(most->box.extent, most->words, most->grid.cell_log2 + 1);
    stack(atlas);
  }
  return atlas;
}

void SkyAtlas::Place::take(const SkyBox& other) {
  const glm::ivec3 room = grid.cells;
  box = other;
  for (int least = 0;; ++least) {
    grid = SkyVisibility::grid_for(box.extent, words, least);
    const glm::ivec3 own = grid.cells;
    if ((own.x <= room.x && own.y <= room.y && own.z <= room.z) || least >= kMaxDepth) break;
  }
  // What has no room at all is open sky.
  if (grid.cells.x > room.x || grid.cells.y > room.y || grid.cells.z > room.z) grid = SkyGrid();
}

std::size_t SkyAtlas::word_count(std::span<const SkyBox> boxes) {
  std::size_t words = 0;
  for (const SkyBox& box : boxes) words += SkyVisibility::word_count(box.extent);
  return words;
}

}  // namespace karst::core
