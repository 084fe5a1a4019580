// SPDX-License-Identifier: MIT
#include "scene/frame/materials/upload_materials.h"

#include <algorithm>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

// As many rows at a time as the staging memory holds. What is painted lies in memory.
Status upload_texels(WorldObject& world, Renderer& gl, const TexelRect& texels) {
  const core::World& terrain = world.terrain.world;
  const std::size_t whole = terrain.materials().blend_map.width * kBlendTexelBytes;
  const std::size_t from = texels.low.x * kBlendTexelBytes;
  const std::size_t row = (texels.high.x - texels.low.x) * kBlendTexelBytes;
  const auto most = static_cast<std::uint32_t>(world.staging.size() / row);
  KARST_ASSERT(most > 0);
  TexelRect piece = texels;
  for (; piece.low.y < texels.high.y; piece.low.y = piece.high.y) {
    piece.high.y = std::min(piece.low.y + most, texels.high.y);
    const std::uint32_t rows = piece.high.y - piece.low.y;
    const auto bytes = world.staging.first(rows * row);
    if (terrain.is_paintable()) {
      for (std::uint32_t k = 0; k < rows; ++k) {
        const auto there = terrain.painted_texels().subspan((piece.low.y + k) * whole + from, row);
        std::ranges::copy(there, bytes.subspan(k * row, row).begin());
      }
    } else if (const Status status = terrain.read_blend_rows(piece.low.y, rows, bytes); !status.ok()) {
      return status;
    }
    if (const Status status = gl.upload_blend_texels(piece, bytes); !status.ok()) return status;
  }
  gl.finish_blend_map();
  return {};
}

}  // namespace

// An image at a time, through the staging memory.
Status upload_materials(WorldObject& world, Renderer& gl) {
  const core::World& terrain = world.terrain.world;
  const MaterialSet& set = terrain.materials();
  if (gl.settings().material_count == 0) return {};
  Status status = gl.set_materials(set);
  for (const TextureArray array : {TextureArray::far, TextureArray::near}) {
    for (int level = 0; status.ok() && level < texture_levels(set.side, array); ++level) {
      const auto image = world.staging.first(texture_image_bytes(set.format, set.side, array, level));
      for (std::uint32_t layer = 0; status.ok() && layer < set.count; ++layer) {
        status = terrain.read_textures(array, level, layer, 1, image);
        if (status.ok()) status = gl.upload_textures(array, level, static_cast<int>(layer), 1, image);
      }
    }
  }
  world.editor.unshown = {};
  const BlendMap& map = set.blend_map;
  return status.ok() && map.exists() ? upload_texels(world, gl, {{0, 0}, {map.width, map.depth}}) : status;
}

Status show_paint(WorldObject& world, Renderer& gl) {
  const PaintChange paint = world.editor.unshown;
  world.editor.unshown = {};
  if (!paint.changed || gl.settings().blend_width == 0) return {};
  if (paint.materials) {
    if (const Status status = gl.set_materials(world.terrain.world.materials()); !status.ok()) return status;
  }
  return paint.texels.exists() ? upload_texels(world, gl, paint.texels) : Status();
}

}  // namespace karst::core
