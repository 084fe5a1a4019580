// SPDX-License-Identifier: MIT
// From what a frame has selected for a view to what the renderer draws of it.
#include "renderer/passes/terrain_pass.h"
#include "scene/frame/renderer_object.h"

namespace karst::core {
namespace {

Show shown(karst::Show show) {
  switch (show) {
    case karst::Show::cascades:
      return Show::cascades;
    case karst::Show::levels:
      return Show::levels;
    case karst::Show::lookups:
      return Show::lookups;
    case karst::Show::materials:
      break;
  }
  return Show::materials;
}

}  // namespace

Status RendererObject::draw_view(std::uint32_t n, const Target& target) {
  if (n >= view_count_) return {StatusCode::invalid_argument, "not one of the frame's views", "view"};
  const std::int64_t start = clock_ns();
  const ViewState& view = world.terrain.views[n];
  ViewInput input;
  input.camera = views_[n].camera;
  input.light = light_;
  input.least_cos2 = view.error_scale().least_cos2;
  input.items = view.items();
  input.shading = views_[n].shading;
  input.skips = {inspection.skip_triplanar, inspection.skip_blend, inspection.skip_detail,
                 inspection.skip_sun};
  if (inspection.lamps) input.lights = world.terrain.world.lights();
  input.pages = world.terrain.residency.pages();
  input.surroundings = surroundings_;
  input.index_table = world.terrain.world.index_table();
  input.max_level = world.terrain.world.info().level;
  input.first_morph_row = world.terrain.residency.first_morph_row(view);
  if (ground_.exists()) {
    input.nodes = ground_.nodes(n);
    input.belts = ground_.belts(n);
    input.first_family_row = ground_.first_row(n);
    input.foot = ground_.foot();
    input.level = ground_.level(input.camera);
    input.has_long_chords = ground_.has_long_chords(n);
    input.pages.family_texels = world.terrain.ground.texels();
    input.pages.family_places = world.terrain.ground.places();
  }
  if (meshes_.exists()) {
    input.meshes = meshes_.list(n).items;
    input.mesh_pages = meshes_.pages();
    input.pages.mesh_texels = meshes_.texels();
  }
  if (imagery_.exists()) {
    input.images = imagery_.place(n);
    input.image_view = n;
  }
  input.light_space = shadows_.light_space();
  input.casters_stray = ground_.casters_stray(view.error_scale());
  input.cascades = shadows_.cascades();
  input.show = shown(inspection.show);
  DrawTarget where;
  where.viewport = target.viewport;
  where.framebuffer = target.framebuffer;
  where.sky = target.sky;
  where.linear = target.output == Output::linear;
  where.depth_zero_to_one = target.depth_zero_to_one;
  where.two_ranges = target.two_ranges;
  if (const DepthRanges ranges = ranges_of(input, where); ranges.count == 2 && ground_.exists())
    input.near_nodes = ground_.nodes_within(n, ranges.far_of(0) * kStepsPerVoxel);
  const Status status = gl.draw(input, where);
  costs.submit_ms += ms_since(start);
  return status;
}

}  // namespace karst::core
