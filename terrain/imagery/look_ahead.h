// SPDX-License-Identifier: MIT
// What a view will lack of the ground's tiles and of imagery when its eye has moved on, for the caches to ask
// for with what their reader has free.
#pragma once

#include <cstdint>

#include "terrain/imagery/image_cache.h"
#include "terrain/nodes/forecast.h"
#include "terrain/paging/tile_cache.h"

namespace karst::core {

// A walk over the ground as it will be seen. Nothing that is drawn depends on it.
struct LookAhead {
  const Forecast* forecast = nullptr;
  TileCache* tiles = nullptr;  // gets what it lacks as wants
  // Null: there is no imagery.
  ImageCache* images = nullptr;
  ImageryInfo imagery;
  bool parallel = false;
  double pixel = 0;  // ImageRequest's
  std::uint32_t most_visits = 0;

  struct Result {
    std::uint32_t visited = 0;  // nodes
    std::uint32_t lacks_tile = 0, lacks_image = 0;
  };
  // Precondition: all but images and imagery are set.
  Result run() const;
};

}  // namespace karst::core
