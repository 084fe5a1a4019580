// SPDX-License-Identifier: MIT
#include "renderer/passes/terrain_pass.h"

#include "renderer/passes/terrain_variants.h"
#include "renderer/resources/index_stream.h"

namespace karst::core {
namespace {

// Show::levels: a call for each run of items of one level, which the shader is told.
Status draw_levels(const GlDevice& device, const Programs& programs, const ViewInput& input,
                   ExpandIndices expand, FrameCounts& counts) {
  for (std::size_t first = 0; first < input.items.size();) {
    const std::uint8_t level = input.items[first].level;
    std::size_t end = first + 1;
    while (end < input.items.size() && input.items[end].level == level) ++end;
    device.gl.Uniform1i(programs.shown_level(), level);
    expand.items = input.items.subspan(first, end - first);
    if (const Status status = draw_items(device, expand, input.max_level, counts); !status.ok())
      return status;
    first = end;
  }
  return {};
}

// z becomes (z + w) / 2: the same depth in the buffer, without what adding 1 takes off small numbers there.
// In double, because of a reversed z near the far plane only the least digits are left.
Camera zero_to_one(Camera camera) {
  for (int column = 0; column < 4; ++column) {
    glm::dvec4& c = camera.clip_from_view[column];
    c.z = 0.5 * (c.z + c.w);
  }
  return camera;
}

ShaderVariant variant_of(const RendererSettings& settings, const ViewInput& input, Writes writes) {
  if (writes == Writes::depth) return ShaderVariant::depth_only;
  if (settings.drape_width > 0) return ShaderVariant::drape;
  if (input.show == Show::cascades) return ShaderVariant::show_cascades;
  if (input.show == Show::levels) return ShaderVariant::show_levels;
  return terrain_variant(
      static_cast<std::uint8_t>(input.shading | (input.cascades.empty() ? 0 : kShadeShadows)));
}

}  // namespace

shader::FrameBlock make_view_block(const RendererSettings& settings, const ViewInput& input,
                                   const DrawTarget& target) {
  const bool on_its_side = (input.quarter_turns & 1) != 0;
  const int upright_height = on_its_side ? target.viewport.width : target.viewport.height;
  shader::FrameBlock block =
      make_frame_block(input.camera, input.least_cos2, input.light, settings.extent, upright_height);
  if (target.depth_zero_to_one) block.clip_from_lattice = clip_from_lattice(zero_to_one(input.camera));
  block.first_rows.x = static_cast<int>(input.first_morph_row);
  turn_frame_block(block, input.quarter_turns);
  block.view_scale.w = target.linear ? 1.0f : 0.0f;
  set_drape(settings.extent, settings.drape_repeat, block);
  set_cascades(input.camera, input.light_space, input.cascades, settings.shadow_size, block);
  const PixelSkips& skips = input.skips;
  block.least_work = {skips.triplanar ? 0 : 3, skips.blend ? 0 : 2, skips.detail ? 0 : 1, skips.sun ? 0 : 1};
  set_lights(input.camera, input.lights, settings.cascades == 0, block);
  return block;
}

Status draw_terrain(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                    const ViewInput& input, Writes writes, FrameCounts& counts) {
  device.push_group("terrain");
  const ShaderVariant variant = variant_of(settings, input, writes);
  device.gl.UseProgram(programs[variant]);
  const ExpandIndices expand{input.index_table, input.items, input.pages, {}};
  const Status status = variant == ShaderVariant::show_levels
                            ? draw_levels(device, programs, input, expand, counts)
                            : draw_items(device, expand, input.max_level, counts);
  device.pop_group();
  return status;
}

}  // namespace karst::core
