// SPDX-License-Identifier: MIT
// Materials of plain colours, and how much of a picture has one of them: what is painted where.
#pragma once

#include <cstring>
#include <vector>

#include "terrain/shading/materials.h"
#include "tests/library/host.h"

namespace karst::test {

enum Colour : std::size_t { kRed, kGreen, kBlue };

// Red ground, and green and blue that no rule lets lie anywhere.
inline core::MaterialSet three_colours() {
  core::MaterialSet set;
  set.count = 3;
  set.side = 16;
  const char* const names[] = {"red", "green", "blue"};
  for (std::size_t m = 0; m < 3; ++m) {
    core::Material& material = set.materials[m];
    std::strcpy(material.name, names[m]);
    if (m > 0) material.slope_low = 3, material.slope_high = 4;
  }
  return set;
}

// Of material m the colour of number m % 3.
inline std::vector<std::byte> textures_of(const core::MaterialSet& set) {
  std::vector<std::byte> textures(core::texture_bytes(set), std::byte{128});
  for (int level = 0; level < core::texture_levels(set.side, core::TextureArray::far); ++level) {
    for (std::uint32_t m = 0; m < set.count; ++m) {
      const std::size_t first = core::texture_offset(set, core::TextureArray::far, level, m);
      const std::size_t last = core::texture_offset(set, core::TextureArray::far, level, m + 1);
      for (std::size_t at = first; at < last; ++at) {
        textures[at] = static_cast<std::byte>(at % 4 == m % 3 || at % 4 == 3 ? 220 : 10);
      }
    }
  }
  return textures;
}

// From above, north up; all of the world.
inline Pixels picture_from_above(const karst::World& world, karst::Renderer& renderer,
                                 const HostPicture& picture) {
  const karst::WorldInfo& info = world.info();
  karst::ViewState view;
  view.width_px = static_cast<std::uint32_t>(picture.width());
  view.height_px = static_cast<std::uint32_t>(picture.height());
  const Vec3 eye{(info.low_m.x + info.high_m.x) / 2, info.high_m.y + 20, (info.low_m.z + info.high_m.z) / 2};
  view.eye = world.from_world(eye);
  const Vec3 north = world.from_world({eye.x, eye.y, eye.z - 1});
  EXPECT_TRUE(look_at(view, world.from_world({eye.x, 0, eye.z}),
                      {north.x - view.eye.x, north.y - view.eye.y, north.z - view.eye.z}));
  for (double& entry : view.clip_from_view) entry = 0;
  view.clip_from_view[0] = 2 / (info.high_m.x - info.low_m.x);
  view.clip_from_view[5] = 2 / (info.high_m.z - info.low_m.z);
  view.clip_from_view[10] = -2.0 / 400;
  view.clip_from_view[14] = -1;
  view.clip_from_view[15] = 1;
  draw_frame(renderer, picture, {view});
  return picture.read();
}

// Pixels of a colour in a part of the picture, columns and rows in shares of it, rows from the south.
inline double share(const Pixels& pixels, Colour colour, double west, double east, double south,
                    double north) {
  int count = 0, all = 0;
  for (int y = static_cast<int>(south * pixels.height); y < static_cast<int>(north * pixels.height); ++y) {
    for (int x = static_cast<int>(west * pixels.width); x < static_cast<int>(east * pixels.width);
         ++x, ++all) {
      const std::uint8_t* p = pixels.at(x, y);
      bool most = true;
      for (std::size_t c = 0; c < 3; ++c) most = most && (c == colour || p[c] < p[colour]);
      count += most;
    }
  }
  return static_cast<double>(count) / all;
}

}  // namespace karst::test
