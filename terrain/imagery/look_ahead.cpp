// SPDX-License-Identifier: MIT
#include "terrain/imagery/look_ahead.h"

#include <array>

#include "terrain/base/check.h"
#include "terrain/imagery/image_view.h"

namespace karst::core {
namespace {

// A node, with the image tile that lies where it does.
struct Visit {
  NodeKey key;
  const Tile* tile = nullptr;  // its own; null: only images are finer here
  std::int32_t low = 0;
  std::int32_t high = 0;
  TilePlace image;
  bool wants_image = false;  // that of its parent is there, and too coarse
};

// Where the image tile over a root lies: of a cube, as far as what is above it is there.
TilePlace place_of_root(ImageCache& images, NodeKey key) {
  NodeKey at = images.root();
  TilePlace place = images.root_place();
  while (at.size > key.size && place.exists()) {
    const std::int32_t layer = images.find_ahead(at);
    if (layer < 0) return {};
    const int below = at.size - 1 - key.size;
    const int quadrant = (key.x >> below & 1) | (key.z >> below & 1) << 1;
    place = images.children(layer).places[quadrant];
    at = at.child(quadrant);
  }
  return place;
}

}  // namespace

LookAhead::Result LookAhead::run() const {
  KARST_ASSERT(forecast != nullptr && tiles != nullptr);
  const GroundInfo& info = forecast->info();
  Result result;
  std::array<Visit, 4 * (kMostSize + 2) + kCubeCells[0] * kCubeCells[1]> stack;
  std::size_t depth = 0;
  const int wide = info.is_cube() ? kCubeCells[0] : 1, deep = info.is_cube() ? kCubeCells[1] : 1;
  for (int z = 0; z < deep; ++z) {
    for (int x = 0; x < wide; ++x) {
      const NodeKey key{info.top_size(), x, z};
      if (!node_exists(info, key)) continue;
      Visit& root = stack[depth++];
      root = {key, tiles->find_ahead(tile_of(key)), info.low, info.high, {}, false};
      if (images == nullptr) continue;
      root.image = place_of_root(*images, key);
      root.wants_image = root.image.exists();
    }
  }
  while (depth > 0 && result.visited < most_visits) {
    Visit visit = stack[--depth];
    ++result.visited;
    NodeMeasure measure;
    if (visit.tile != nullptr) {
      measure = visit.tile->nodes[node_in_tile(visit.key)];
      visit.low = measure.low;
      visit.high = measure.high;
    }
    measure.low = visit.low;
    measure.high = visit.high;
    const NodeBall ball = forecast->ball(measure, visit.key);
    if (!forecast->sees(ball)) continue;
    const float px =
        visit.tile != nullptr && visit.key.size > 0 ? forecast->need(measure, visit.key, ball) : 0.0f;
    const Tile* below = nullptr;
    if (px > 0) {
      const NodeKey key = tile_of(visit.key.child(0));
      below = tiles->find_ahead(key);
      if (below == nullptr) {
        tiles->want(key, visit.tile->children[(key.x & 1) | (key.z & 1) << 1], px);
        ++result.lacks_tile;
      }
    }
    const ImageChildren* children = nullptr;
    if (visit.wants_image) {
      const NodeBox box = node_box(info, measure, visit.key);
      const double texel = texel_voxels(info, visit.key.size);
      const double here = pixel_voxels(box, forecast->eye(), parallel, pixel);
      const std::int32_t layer = images->find_ahead(visit.key);
      if (layer < 0) {
        images->want(visit.key, visit.image, static_cast<float>(2 * texel / here));
        ++result.lacks_image;
      } else if (texel > here && visit.key.size > imagery.least_size) {
        children = &images->children(layer);
      }
    }
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const bool has_image = children != nullptr && children->places[quadrant].exists();
      if (below == nullptr && !has_image) continue;
      const NodeKey key = visit.key.child(quadrant);
      if (!node_exists(info, key)) continue;
      KARST_ASSERT(depth < stack.size());
      Visit& child = stack[depth++];
      child = {key, below, visit.low, visit.high, {}, has_image};
      if (has_image) child.image = children->places[quadrant];
    }
  }
  return result;
}

}  // namespace karst::core
