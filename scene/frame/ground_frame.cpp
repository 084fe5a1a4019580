// SPDX-License-Identifier: MIT
#include "scene/frame/ground_frame.h"

#include <algorithm>
#include <cmath>

#include "scene/frame/vertex_work.h"

namespace karst::core {
namespace {

// A frame that waits gives up after so many rounds of asking: more than tiles can be deep.
constexpr int kMostRounds = 4 * kMostSize;
// Of the families, one in so many is for what casts shadows and is not seen: ground that is too
// coarse there stands above what is seen, and darkens it.
constexpr std::uint32_t kCastersShare = 3;
// Where families are too few for the errors that views aim at: by so much these grow, and shrink again a
// frame where less than that share of the families is taken. What growing frees is less than what is left.
constexpr double kGrow = 1.19, kShrink = 0.97, kEasyShare = 0.6, kMostScale = 64;
// Height in which the earth's air thins by e.
constexpr double kAirThinsM = 8'000;
// Radii by which a chord may be below what is level where heights are those of its pixels: 25 m of the earth.
constexpr double kShortChord = 1.0 / 250'000;

// At an error that is so many times as large as the view's.
void aim(const ViewState& view, double times, GroundRequest& request) {
  request.scale = view.error_scale();
  request.scale.steps_per_step =
      static_cast<float>((double{request.scale.steps_per_step} - 1.0) / times + 1.0);
  request.error_px = view.settings().error_px * times;
}

}  // namespace

void GroundFrame::create(TerrainParts& terrain, Renderer& renderer, const Inspection& inspection) {
  terrain_ = &terrain;
  renderer_ = &renderer;
  inspection_ = &inspection;
}

void GroundFrame::begin_frame(double work_ms, FrameCosts& costs) {
  if (!exists()) return;
  const std::int64_t start = clock_ns();
  Ground& ground = terrain_->ground;
  ground.begin_frame();
  const OwnWork own(*inspection_);
  while (ground.poll(true) > 0 && ms_since(start) < work_ms) {
  }
  costs.generate_ms += ms_since(start);
}

// Selects views first .. end - 1 and asks for what they lack, all or what comes soon; with wait again and
// again.
void GroundFrame::complete(std::size_t first, std::size_t end, bool all, bool wait) {
  Ground& ground = terrain_->ground;
  const OwnWork own(*inspection_);
  ground.begin_tries();
  for (int round = 0; round < kMostRounds; ++round) {
    if (round > 0) ground.undo_tries();
    std::uint32_t lacking = 0;
    for (std::size_t v = first; v < end; ++v) {
      ground.select(v, requests_[v]);
      lacking += ground.view(v).result().lacks_tile;
    }
    ground.ask(all);
    if (!wait || lacking == 0 || !ground.wait()) return;
    if (ground.poll() == 0 && ground.counts().under_way == 0) return;  // nothing can be read, or finds room
  }
}

void GroundFrame::select(std::span<ViewState> views, std::span<const ViewRequest> requests,
                         std::span<const glm::dvec3> motions, bool wait, bool casts, FrameCosts& costs) {
  if (!exists()) return;
  const std::int64_t start = clock_ns();
  const std::uint32_t families = terrain_->ground.row_count() - 1;
  terrain_->ground.leave_families(casts ? families / kCastersShare : 0);
  for (std::size_t v = 0; v < views.size(); ++v) {
    GroundRequest& request = requests_[v];
    request = {};
    request.camera = requests[v].camera;
    request.scale = views[v].error_scale();
    request.error_px = views[v].settings().error_px;
    const LodSettings& lod = views[v].settings();
    request.morphing = lod.mode != LodMode::full;
    // As K's patches: one whose side is a node's is at the node's level from half of that distance on.
    if (lod.mode == LodMode::distance) request.sides_away = std::max(lod.distance_voxels, 1e-3) / 4;
    request.culls = requests[v].frustum_culling;
    if (!motions.empty()) request.motion = motions[v];
    request.regions = drawable(views[v].selection().whole_parts | requests[v].skipped_parts | mesh_part()) &
                      ~terrain_->residency.fresh_parts();
  }
  all_ = motions.empty();
  complete_views(views, wait);
  for (std::size_t v = 0; v < views.size(); ++v) views[v].keep_parts(parts_drawn(v));
  costs.select_ms += ms_since(start);
}

// Selects the views at errors for which there are families: a frame that waits finds them, others come nearer
// from frame to frame. Where distance alone decides errors do not matter.
void GroundFrame::complete_views(std::span<const ViewState> views, bool wait) {
  const bool governed = !views.empty() && requests_[0].sides_away == 0;
  if (wait || !governed) error_scale_ = 1;
  bool rested = false;
  for (;;) {
    for (std::size_t v = 0; v < views.size(); ++v) aim(views[v], error_scale_, requests_[v]);
    complete(0, views.size(), all_, wait);
    std::uint32_t lacks_room = 0;
    for (std::size_t v = 0; v < views.size(); ++v) lacks_room += terrain_->ground.view(v).result().lacks_room;
    if (!governed) return;
    if (lacks_room > 0 && wait && !rested) {
      rested = true;
      renderer_->finish();
      terrain_->ground.rest();
      terrain_->ground.undo_tries();
      continue;
    }
    if (lacks_room > 0) {
      error_scale_ = std::min(error_scale_ * kGrow, kMostScale);
      if (!wait || error_scale_ == kMostScale) return;
      terrain_->ground.undo_tries();
      continue;
    }
    if (!wait && terrain_->ground.share_of_families() < kEasyShare)
      error_scale_ = std::max(error_scale_ * kShrink, 1.0);
    return;
  }
}

std::uint32_t GroundFrame::parts_to_skip(std::size_t view) const {
  return exists() ? requests_[view].regions & ~parts_drawn(view) : 0;
}

bool GroundFrame::lacks_skipped(std::span<const ViewRequest> requests) const {
  for (std::size_t v = 0; v < requests.size(); ++v) {
    if ((requests[v].skipped_parts & parts_drawn(v)) != 0) return true;
  }
  return false;
}

bool GroundFrame::select_casters(const ViewState& view, const Cascade& cascade, double texel,
                                 std::uint32_t parts, bool wait, FrameCosts& costs) {
  if (!exists()) return true;
  const std::int64_t start = clock_ns();
  GroundRequest& request = requests_[shadow_view()];
  request = {};
  request.camera = &cascade.eye;
  request.error_px = view.settings().error_px;
  request.morphing = view.settings().mode != LodMode::full;
  request.frustum = &cascade.frustum;
  const std::uint32_t ground_families = terrain_->ground.row_count() - 1;
  terrain_->ground.leave_families(0);
  request.spared_error = static_cast<float>(texel);
  request.most_splits = ground_families / 4 * 3;
  request.regions = drawable(parts) & ~terrain_->residency.fresh_parts();
  for (double times = error_scale_; times < 2 * kMostScale; times *= 2) {
    aim(view, times, request);
    request.scale.least_cos2 = cascade.least_cos2;
    complete(shadow_view(), shadow_view() + 1, all_ || wait, wait);
    if (terrain_->ground.view(shadow_view()).result().lacks_room == 0) break;
    terrain_->ground.undo_tries();
  }
  costs.select_ms += ms_since(start);
  return terrain_->ground.view(shadow_view()).result().lacks_tile == 0;
}

Status GroundFrame::upload(FrameCosts& costs) {
  if (!exists()) return {};
  const std::int64_t start = clock_ns();
  Ground& ground = terrain_->ground;
  PageTable pages = terrain_->residency.pages();
  pages.family_texels = ground.texels();
  pages.family_places = ground.places();
  NodeUpload node;
  while (ground.next_node(node)) {
    NodePage page;
    page.origin = node.origin;
    page.size = node.size;
    page.quadrant = node.quadrant;
    page.key = node.key;
    page.row = node.row;
    if (const Status status =
            renderer_->upload_node(pages, node.page, page, node.vertices.first<kNodePageVertices>());
        !status.ok()) {
      return status;
    }
    ++costs.generated;
  }
  for (std::size_t v = 0; v <= shadow_view(); ++v) {
    for (MorphRows rows; !(rows = ground.take_rows(v)).halves.empty();) {
      const std::uint32_t first = first_row(v) + rows.first_row;
      if (const Status status = renderer_->upload_morph_rows(first, rows.halves); !status.ok()) return status;
      costs.morph_bytes += rows.halves.size_bytes();
    }
  }
  costs.upload_ms += ms_since(start);
  return {};
}

FrameLevel GroundFrame::level(const Camera& camera) const {
  FrameLevel level;
  if (!is_curved()) return level;
  const GroundInfo& info = terrain_->ground.info();
  const Basis& basis = info.basis;
  const double step_m = basis.height_unit_m / kVertexStep, voxel_m = step_m * kStepsPerVoxel;
  const glm::dvec3 eye_m = eye_lattice(camera) * step_m;
  level.view = make_level_view(basis, eye_m, voxel_m, basis.height_m(info.low));
  level.up = glm::vec3(up_of(basis, eye_m));
  const Surroundings& around = terrain_->world.surroundings();
  if (around.has_water()) {
    level.has_water = true;
    level.water_height = around.water_level;
    const double radius = level_radius_m(basis, voxel_m);
    const double water = 1.0 + double{around.water_level} * voxel_m / radius;
    level.water_over = static_cast<float>(double{level.view.eye.x} - (water - 1.0) * (water + 1.0));
  }
  if (!basis.is_ellipsoid()) return level;
  const double over = double{level.view.eye.x};
  if (over > 0) level.dip = static_cast<float>(std::sqrt(over / (1.0 + over)));
  level.sky = static_cast<float>(std::exp(-std::max(0.0, double{level.view.eye.w}) * voxel_m / kAirThinsM));
  level.thins = static_cast<float>(voxel_m / kAirThinsM);
  if (basis.kind == BasisKind::geographic) {
    const double low = 1.0 + basis.height_m(info.low) / basis.radius_m;
    level.plain_over = static_cast<float>(low * low - 1.0);
    level.has_plain = true;
  }
  return level;
}

bool GroundFrame::has_long_chords(std::size_t view) const {
  if (!is_curved()) return false;
  const Basis& basis = terrain_->ground.info().basis;
  const double most_m = basis.kind == BasisKind::function ? 0.0 : kShortChord * std::abs(basis.radius_m);
  return bend_m(basis, terrain_->ground.view(view).result().greatest_size) > most_m;
}

glm::dmat3 GroundFrame::axes(const Camera& camera) const {
  const Basis& basis = terrain_->ground.info().basis;
  return axes_of(basis, eye_lattice(camera) * (basis.height_unit_m / kVertexStep));
}

void GroundFrame::build_belts(std::size_t view, std::span<const std::uint8_t> levels) {
  if (!exists()) return;
  ResidentPool& pool = terrain_->residency.pool();
  terrain_->ground.begin_belts(view);
  for (std::size_t n = 0; n < terrain_->world.parts().size(); ++n) {
    const WorldPart& part = terrain_->world.parts()[n];
    if ((parts_drawn(view) >> n & 1u) == 0) continue;
    BuildBelts belts;
    belts.region = n;
    belts.first_node_page = renderer_->settings().vertex_pages;
    if ((mesh_part() >> n & 1u) != 0) {
      belts.blocks = &terrain_->isosurface.rim();
      belts.first_mesh_page = belts.first_node_page + renderer_->settings().family_pages;
      terrain_->ground.add_belt(view, belts);
      continue;
    }
    belts.rim = part.rim;
    belts.levels = part.of(levels);
    belts.resident = part.of(pool.levels());
    belts.pages = pool.pages();
    belts.pages.first_page = part.of(belts.pages.first_page);
    if (terrain_->ground.add_belt(view, belts) == 0) continue;
    // The GPU reads vertices of patches that are out of view, too: they must not be given to others.
    for (const RegionRim::Edge& edge : part.rim->edges()) {
      const PatchId patch = edge.edge.patch();
      const int level = std::min<int>(belts.levels[patch], belts.resident[patch]);
      if (level > 0) pool.see(part.first + patch, level);
    }
  }
}

std::size_t GroundFrame::nodes_within(std::size_t view, double steps) const {
  const GroundView& ground = terrain_->ground.view(view);
  std::size_t count = ground.items().size();
  // Apparent distances are not above those along forward.
  while (count > 0 && double{ground.node_of(count - 1).least_apparent} >= steps) --count;
  return count;
}

GroundFrame::Sum GroundFrame::sum(std::size_t view) const {
  if (!exists()) return {};
  const GroundView::Result& result = terrain_->ground.view(view).result();
  return {.bound_px = double{result.bound_px},
          .lacking = result.lacks_tile,
          .lacks_room = result.lacks_room,
          .left_out = result.left_out,
          .sizes_left_out = static_cast<std::uint32_t>(result.left_out_below),
          .triangles = result.triangles,
          .drawn = result.drawn,
          .culled = result.culled,
          .visited = result.visited};
}

}  // namespace karst::core
