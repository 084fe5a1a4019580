// SPDX-License-Identifier: MIT
#include "tests/support/morphed_surface.h"

#include <array>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"
#include "terrain/ground/node_place.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/generate_vertices.h"

namespace karst::test {
using namespace core;
namespace {

void require(const Status& status) {
  if (!status.ok()) std::abort();
}

glm::ivec2 grid_of(int index, int side) {
  return {index % side, index / side};
}

int cross(glm::ivec2 a, glm::ivec2 b) {
  return a.x * b.y - a.y * b.x;
}

}  // namespace

std::vector<SurfacePoint> points_on_level(int full_level, int level) {
  std::vector<std::uint16_t> table(index_count(kMaxLevel));
  require(build_index_tables(kMaxLevel, table));
  std::vector<std::uint16_t> grid_order(static_cast<std::size_t>(patch_vertices(full_level)));
  require(build_grid_order(full_level, grid_order));
  const int side = patch_side(full_level);
  std::vector<SurfacePoint> points(grid_order.size());
  IndexRange ranges[kMaxIndexRanges];
  if (index_ranges(level, 0, 0, ranges) != 1) std::abort();
  for (std::uint32_t t = 0; t < ranges[0].count; t += 3) {
    const std::uint16_t* index = table.data() + ranges[0].first + t;
    const glm::ivec2 a = grid_of(grid_order[index[0]], side);
    const glm::ivec2 b = grid_of(grid_order[index[1]], side);
    const glm::ivec2 c = grid_of(grid_order[index[2]], side);
    const int area = cross(b - a, c - a);
    for (std::size_t v = 0; v < points.size(); ++v) {
      const glm::ivec2 p = grid_of(grid_order[v], side);
      const int wa = cross(b - p, c - p);
      const int wb = cross(c - p, a - p);
      const int wc = cross(a - p, b - p);
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const auto part = [area](int w) { return static_cast<float>(w) / static_cast<float>(area); };
      points[v] = {{index[0], index[1], index[2]}, {part(wa), part(wb), part(wc)}};
    }
  }
  return points;
}

MorphedSurface::MorphedSurface(const TestWorld& world)
    : world_(world),
      level_(world.heights().level),
      bounds_(world.surface().patches.size()),
      entries_(static_cast<std::size_t>(patch_vertices(level_))) {
  const TestScratch scratch;
  GenerateVertices generate;
  generate.surface = world_.surface();
  generate.heights = world_.heights();
  generate.level = level_;
  generate.scratch = scratch.get();
  require(generate.validate());
  for (PatchId p = 0; p < bounds_.size(); ++p) {
    vertices_.emplace_back(static_cast<std::size_t>(patch_vertices(level_)));
    generate.run(p, vertices_.back(), &bounds_[p]);
  }
  require(build_morph_entries(level_, entries_));
  on_level_.resize(static_cast<std::size_t>(level_) + 1);
  for (int m = 1; m <= level_; ++m) on_level_[static_cast<std::size_t>(m)] = points_on_level(level_, m);
}

std::vector<glm::vec3> MorphedSurface::moved(PatchId patch, int drawn, const Camera& camera,
                                             const ErrorScale& scale, std::span<const PatchLod> lods) const {
  const glm::ivec3 origin = patch_origin(surface().volume_of(patch)) / kStepsPerVoxel;
  const glm::vec3 forward = make_lod_eye(camera, scale.least_cos2).forward;
  std::array<std::uint16_t, kMorphRow> row;
  make_morph_row(surface(), lods, patch, row);
  std::vector<glm::vec3> result(static_cast<std::size_t>(patch_vertices(drawn)));
  for (std::size_t v = 0; v < result.size(); ++v) {
    const GpuVertex& g = vertices_[patch][v];
    const glm::ivec3 at(g.position[0], g.position[1], g.position[2]);
    const glm::ivec3 to(g.morph[0], g.morph[1], g.morph[2]);
    const glm::vec3 home = node_place(camera.voxel, 0, origin, at);
    const glm::vec3 target = node_place(camera.voxel, 0, origin, to);
    const float apparent = apparent_distance(home - camera.fine, forward, scale.least_cos2);
    const float share = morph_share(apparent, threshold_steps(row[entries_[v]]));
    result[v] = morph_position(home, glm::vec3(to - at), target, share);
  }
  return result;
}

void MorphedSurface::points(PatchId patch, int drawn, unsigned lower_edges, std::span<const glm::vec3> moved,
                            std::vector<glm::dvec3>& out) const {
  std::vector<glm::dvec3> at(moved.begin(), moved.end());
  const int n = patch_cells(drawn);
  for (int e = 0; e < 4 && drawn > 1; ++e) {
    if ((lower_edges >> e & 1u) == 0) continue;
    const GridLine line = GridLine::along_edge(e, 0, drawn, false);
    const auto index = [&](int t) {
      return static_cast<std::size_t>(vertex_order(drawn, line.i0 + t * line.di, line.j0 + t * line.dj));
    };
    for (int t = 1; t < n; t += 2) at[index(t)] = 0.5 * (at[index(t - 1)] + at[index(t + 1)]);
  }
  out.resize(vertices_[patch].size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const SurfacePoint& p = on_level_[static_cast<std::size_t>(drawn)][v];
    out[v] = double{p.weight[0]} * at[p.vertex[0]] + double{p.weight[1]} * at[p.vertex[1]] +
             double{p.weight[2]} * at[p.vertex[2]];
  }
}

void MorphedSurface::full_points(PatchId patch, const Camera& camera, std::vector<glm::dvec3>& out) const {
  const glm::dvec3 offset(patch_origin(surface().volume_of(patch)) - camera.voxel * kStepsPerVoxel);
  out.resize(vertices_[patch].size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const GpuVertex& g = vertices_[patch][v];
    out[v] = offset + glm::dvec3(g.position[0], g.position[1], g.position[2]);
  }
}

Projection::Projection(const Camera& camera, glm::ivec2 size_px)
    : view_from_world_(camera.view_from_world),
      clip_from_view_(camera.clip_from_view),
      forward_(camera.forward),
      eye_(camera.fine),
      half_px_(0.5 * glm::dvec2(size_px)),
      nearest_(camera.reversed_depth ? 1 : -1) {}

glm::dvec4 Projection::clip(glm::dvec3 point) const {
  return clip_from_view_ * glm::dvec4(view_from_world_ * (point - eye_) / double{kStepsPerVoxel}, 1.0);
}

double Projection::depth(glm::dvec3 point) const {
  return glm::dot(forward_, point - eye_);
}

glm::dvec2 Projection::pixels(glm::dvec3 point) const {
  const glm::dvec4 c = clip(point);
  return glm::dvec2(c) / c.w * half_px_;
}

bool Projection::inside(glm::dvec3 point) const {
  const glm::dvec4 c = clip(point);
  return std::abs(c.x) <= c.w && std::abs(c.y) <= c.w && c.z * nearest_ <= c.w;
}

}  // namespace karst::test
