// SPDX-License-Identifier: MIT
#include "renderer/passes/terrain_pass.h"

#include <utility>

#include "renderer/passes/screen_pass.h"
#include "renderer/passes/terrain_variants.h"
#include "renderer/resources/index_stream.h"
#include "renderer/resources/object_table.h"
#include "renderer/resources/vertex_pages.h"

namespace karst::core {
namespace {

// Show::levels: a call for each run of items of one level, which the shader is told; it knows nodes' sizes.
Status draw_levels(const GlDevice& device, const Programs& programs, const ViewInput& input,
                   ExpandIndices expand, FrameCounts& counts) {
  const std::span<const DrawItem> nodes = std::exchange(expand.nodes, {});
  const std::span<const std::uint32_t> belts = std::exchange(expand.belts, {});
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
  expand.items = {};
  expand.nodes = nodes;
  expand.belts = belts;
  return draw_items(device, expand, input.max_level, counts);
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

ShaderVariant variant_of(const RendererSettings& settings, const ViewInput& input, const DrawTarget& target) {
  if (target.writes == Writes::depth) return ShaderVariant::depth_only;
  if (settings.drape_width > 0) return target.linear ? ShaderVariant::drape_linear : ShaderVariant::drape;
  if (input.show == Show::cascades) return ShaderVariant::show_cascades;
  if (input.show == Show::levels) return ShaderVariant::show_levels;
  if (input.show == Show::lookups) return ShaderVariant::show_lookups;
  // Beside a G-buffer there is one that does everything.
  const unsigned all = settings.deferred() ? kShadeAll & ~kShadeShadows : 0u;
  return variant_for(ShaderVariant::terrain, frame_shading(input) | all);
}

}  // namespace

shader::FrameBlock make_view_block(const RendererSettings& settings, const ViewInput& input,
                                   const DrawTarget& target) {
  const bool on_its_side = (input.quarter_turns & 1) != 0;
  const int upright_height = on_its_side ? target.viewport.width : target.viewport.height;
  shader::FrameBlock block =
      make_frame_block(input.camera, input.least_cos2, input.light, settings.sky, upright_height);
  if (target.depth_zero_to_one) block.clip_from_lattice = clip_from_lattice(zero_to_one(input.camera));
  block.first_rows.x = static_cast<int>(input.first_morph_row);
  block.first_rows.y = static_cast<int>(input.first_family_row);
  block.camera_fine.w = foot_from(input.camera, input.foot);
  turn_frame_block(block, input.quarter_turns);
  block.view_scale.w = target.linear ? 1.0f : 0.0f;
  set_drape(settings.extent, settings.drape_repeat, block);
  set_surroundings(input.camera, input.surroundings, block);
  set_level(input.level, block);
  set_cascades(input.camera, input.light_space, input.cascades, settings.shadow_size, block);
  block.shadow_x.w = input.casters_stray;
  const PixelSkips& skips = input.skips;
  block.least_work = {skips.triplanar ? 0 : 1, skips.blend ? 0 : 1, skips.detail ? 0 : 1, skips.sun ? 0 : 1};
  set_images(input.images, input.image_view, page_rows(settings.all_pages()), block);
  set_lights(input.camera, input.lights, settings.cascades == 0, block);
  set_screen(input, target, block);
  return block;
}

DepthRanges ranges_of(const ViewInput& input, const DrawTarget& target) {
  if (!target.two_ranges || target.depth_zero_to_one || input.camera.parallel) return {};
  return depth_ranges(input.camera.clip_from_view, input.camera.reversed_depth);
}

ViewInput enter_range(const GlDevice& device, const DepthRanges& ranges, int range, const ViewInput& input,
                      shader::FrameBlock block) {
  // Clip z of the range; x, y and w stay the same bits.
  Camera camera = input.camera;
  const double w = -camera.clip_from_view[2][3];
  camera.clip_from_view[2][2] = -ranges.a(range) * w;
  camera.clip_from_view[3][2] = ranges.b(range) * w;
  const glm::mat4 clip = clip_from_lattice(camera);
  for (int column = 0; column < 4; ++column) block.clip_from_lattice[column][2] = clip[column][2];
  use_block(device, Object::frame_block, KARST_BINDING_FRAME, as_bytes(block));
  const float from = 0.5f * static_cast<float>(range);
  device.gl.DepthRangef(from, from + 0.5f);
  ViewInput part = input;
  if (range == 0 && input.near_nodes < part.nodes.size()) part.nodes = part.nodes.first(input.near_nodes);
  return part;
}

void leave_ranges(const GlDevice& device) {
  device.gl.DepthRangef(0.0f, 1.0f);
}

unsigned frame_shading(const ViewInput& input) {
  return input.shading | (input.cascades.empty() ? 0u : unsigned{kShadeShadows}) |
         (input.lights.empty() ? 0u : unsigned{kShadeLamps});
}

void clear_geometry(const GlDevice& device, const ViewInput& input) {
  constexpr GLuint kNothing[4] = {};
  device.gl.ClearBufferuiv(GL_COLOR, 0, kNothing);
  const GLfloat far = input.camera.reversed_depth ? 0.0f : 1.0f;
  device.gl.ClearBufferfv(GL_DEPTH, 0, &far);
}

Status draw_geometry(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                     const ViewInput& input, FrameCounts& counts) {
  const Gl& gl = device.gl;
  device.push_group("geometry");
  gl.UseProgram(programs[ShaderVariant::geometry]);
  const Status status = draw_items(device, expand_of(settings, input), input.max_level, counts);
  device.pop_group();
  return status;
}

Status draw_terrain(const GlDevice& device, const RendererSettings& settings, const Programs& programs,
                    const ViewInput& input, const DrawTarget& target, FrameCounts& counts) {
  device.push_group("terrain");
  const ShaderVariant variant = variant_of(settings, input, target);
  device.gl.UseProgram(programs[variant]);
  const ExpandIndices expand = expand_of(settings, input);
  const Status status = variant == ShaderVariant::show_levels
                            ? draw_levels(device, programs, input, expand, counts)
                            : draw_items(device, expand, input.max_level, counts);
  device.pop_group();
  return status;
}

}  // namespace karst::core
