// SPDX-License-Identifier: MIT
#include "renderer/input/settings.h"

#include <bit>

#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/shadow/cascades.h"

namespace karst::core {
namespace {

Status invalid(const char* what, const char* field, std::uint64_t value = 0) {
  return {StatusCode::invalid_argument, what, field, value};
}

bool inside(std::int64_t value, std::int64_t least, std::int64_t most) {
  return value >= least && value <= most;
}

}  // namespace

Status RendererSettings::validate() const {
  if (!inside(vertex_pages, 1, kMostPages))
    return invalid("not within its range", "vertex_pages", vertex_pages);
  if (!inside(morph_rows, 1, kMostViews * kMostPages))
    return invalid("not within its range", "morph_rows", morph_rows);
  if (family_pages % 4 != 0 || !inside(family_pages, 0, kMostPages - std::int64_t{vertex_pages}))
    return invalid("not 4 a family, or too many", "family_pages", family_pages);
  if (!inside(family_rows, family_pages > 0 ? 1 : 0, std::int64_t{kMostViews + 1} * (family_pages / 4 + 1)))
    return invalid("not within its range", "family_rows", family_rows);
  if (!inside(mesh_pages, 0, kMostPages - std::int64_t{vertex_pages} - family_pages))
    return invalid("too many", "mesh_pages", mesh_pages);
  if (mesh_materials && (mesh_pages == 0 || material_count == 0 || drape_width != 0))
    return invalid("there are no meshes, or no materials", "mesh_materials");
  if (!inside(stream_indices, kLeastIndicesPerPatch, 1 << 26)) {
    return invalid("not within its range", "stream_indices", stream_indices);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!inside(extent[axis], 1, 1 << 20)) return invalid("not within 1..2^20 voxels", "extent");
    if (!inside(sky.cells[axis], 1, SkyVisibility::kMostSide)) return invalid("not within 1..256", "sky");
  }
  if (!inside(material_count, 0, kMostMaterials)) return invalid("not within 0..8", "material_count");
  if (material_count > 0 &&
      (!std::has_single_bit(material_side) || !inside(material_side, kLeastTextureSide, kMostTextureSide))) {
    return invalid("not a power of two within 16..1024", "material_side");
  }
  if (blend_width != 0 || blend_depth != 0) {
    if (!inside(blend_width, 1, kMostBlendSide)) return invalid("not within 1..1024", "blend_width");
    if (!inside(blend_depth, 1, kMostBlendSide)) return invalid("not within 1..1024", "blend_depth");
    if (material_count == 0) return invalid("there are no materials to blend", "blend_width");
  }
  if (!inside(image_layers, 0, kMostImageLayers))
    return invalid("not within 0..256", "image_layers", image_layers);
  const bool has_images = image_layers > 0;
  if (!inside(image_views, has_images ? 1 : 0, has_images ? kMostViews : 0))
    return invalid("not within its range", "image_views", image_views);
  if (has_images != (image_format != ImageFormat::none))
    return invalid("does not fit image_layers", "image_format");
  if (!inside(anisotropy, 0, kMostAnisotropy)) return invalid("not within 0..16", "anisotropy");
  if (!inside(cascades, 0, kMostCascades)) return invalid("not within 0..3", "cascades");
  if (!inside(air_blocks, 0, kMostAirBlocks)) return invalid("not within 0..8", "air_blocks");
  CascadeSettings shadows;
  shadows.size = shadow_size;
  if (!shadows.validate().ok()) return invalid("not a multiple of 16 within 512..2048", "shadow_size");
  if (shadow_bits != 16 && shadow_bits != 24) return invalid("neither 16 nor 24", "shadow_bits");
  if (deferred_width != 0 || deferred_height != 0) {
    if (!inside(deferred_width, 1, kMaxPicture))
      return invalid("not within 1..16384 pixels", "deferred_width");
    if (!inside(deferred_height, 1, kMaxPicture))
      return invalid("not within 1..16384 pixels", "deferred_height");
  }
  if (drape_width != 0 || drape_height != 0) {
    if (!inside(drape_width, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "drape_width");
    if (!inside(drape_height, 1, kMaxPicture)) return invalid("not within 1..16384 pixels", "drape_height");
    if (!(drape_repeat >= 0x1p-10 && drape_repeat <= 0x1p10)) {
      return invalid("not within 2^-10..2^10", "drape_repeat");
    }
  }
  return {};
}

}  // namespace karst::core
