// SPDX-License-Identifier: MIT
#include "terrain/imagery/image_view.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/basis/basis.h"
#include "terrain/ground/ground_box.h"

namespace karst::core {
namespace {

// A tile that is to be looked at, beside the node that lies where it does.
struct Visit {
  NodeKey key;
  std::int32_t node = -1;  // of the view; -1: it has none so small
  std::int32_t low = 0, high = 0;
  TilePlace place;
};

// Whether a tile will still be looked up when it has come.
bool needs(const ImageRequest& request, const NodeBox& box, NodeKey key, double texel,
           const ImageCache& cache) {
  if (request.forecast == nullptr || key == cache.root()) return true;
  const NodeBall ball{0.5 * (box.low + box.high), 0.5 * glm::length(box.high - box.low)};
  if (!request.forecast->sees(ball)) return false;
  // It is because its parent's texels are too large.
  return 2 * texel > pixel_voxels(box, request.forecast->eye(), request.camera->parallel, request.pixel);
}

// Pixels that a texel covers where nothing but the ground's own colours would be drawn.
constexpr float kMostUrgent = 1e6f;

// The node that lies where a tile of the top size does; -1: the view did not look at it.
std::int32_t root_of(std::span<const GroundView::Node> nodes, NodeKey key) {
  for (std::size_t n = 0; n < nodes.size() && nodes[n].key.size >= key.size; ++n) {
    if (nodes[n].key == key) return static_cast<std::int32_t>(n);
  }
  return -1;
}

std::size_t entry_of(int x, int z) {
  return static_cast<std::size_t>(z * kImageWindow + x);
}

}  // namespace

double texel_voxels(const GroundInfo& info, int size) {
  return std::ldexp(std::max(info.steps[0], info.steps[1]) / kStepsPerVoxel / kTexelsPerSample, size);
}

double pixel_voxels(const NodeBox& box, const glm::dvec3& eye, bool parallel, double pixel) {
  const glm::dvec3 nearest = glm::clamp(eye, box.low, box.high) - eye;
  return std::max((parallel ? 1.0 : glm::length(nearest) / kStepsPerVoxel) * pixel, 1e-9);
}

void ImageView::reset() {
  made_ = false;
  std::fill(storage_.table.begin(), storage_.table.end(), std::uint16_t{0});
  dirty_ = storage_.table.empty() ? 0u : (1u << kImageSizes) - 1;
}

void ImageView::select(const GroundInfo& info, const ImageryInfo& imagery, const GroundView& ground,
                       const ImageRequest& request, ImageCache& cache) {
  KARST_ASSERT(info.exists() && imagery.exists() && request.camera != nullptr);
  result_ = {};
  const Camera& camera = *request.camera;
  const glm::dvec3 eye = glm::dvec3(camera.voxel) * double{kStepsPerVoxel} + glm::dvec3(camera.fine);
  place_ = {};
  place_.least_size = imagery.least_size;
  place_.top_size = info.top_size();
  place_.root_size = image_top_size(info);
  if (info.basis.is_curved()) {
    place_.centre[0] = place_.centre[1] = 0;
    GridPlace at;
    if (grid_of(info.basis, eye * (info.basis.height_unit_m / kVertexStep), at)) {
      for (int axis = 0; axis < 2; ++axis) {
        const double last = std::ceil(static_cast<double>(info.samples[axis] - 1) / kNodeQuads) - 1;
        const double node = std::floor((axis == 0 ? at.i : at.k) / kNodeQuads);
        place_.centre[axis] = static_cast<std::int32_t>(std::clamp(node, 0.0, last));
      }
    }
  }
  for (int axis = 0; axis < 2 && !info.basis.is_curved(); ++axis) {
    const double tile_steps = info.steps[axis] * kNodeQuads;
    const auto corner = static_cast<double>(info.corner[axis] * kVertexStep);
    const double at = (eye[2 * axis] - corner) / tile_steps;
    const double last = std::ceil(static_cast<double>(info.samples[axis] - 1) / kNodeQuads) - 1;
    const double centre = std::clamp(std::floor(at), 0.0, last);
    place_.centre[axis] = static_cast<std::int32_t>(centre);
    place_.eye[axis] = static_cast<float>(at - centre);
    place_.tiles_a_voxel[axis] = static_cast<float>(kStepsPerVoxel / tile_steps);
  }
  place_.texels_a_voxel = static_cast<float>(1 / texel_voxels(info, 0));

  const std::span<const GroundView::Node> nodes = ground.nodes();
  std::array<Visit, 4 * kImageSizes> stack;
  std::size_t depth = 0;
  stack[depth++] = {cache.root(), nodes.empty() || info.is_cube() ? -1 : 0, info.low, info.high,
                    cache.root_place()};
  while (depth > 0) {
    Visit visit = stack[--depth];
    if (visit.node >= 0) {
      const GroundView::Node& node = nodes[static_cast<std::size_t>(visit.node)];
      if (!node.in_view) continue;
      if (node.tile != nullptr) {
        const NodeMeasure& measure = node.tile->nodes[node_in_tile(node.key)];
        visit.low = measure.low;
        visit.high = measure.high;
      }
    }
    ++result_.visited;
    if (visit.key.size > info.top_size()) {
      // On the way to the roots of a cube.
      const std::int32_t layer = cache.find(visit.key);
      if (layer < 0) {
        ++result_.lacking;
        cache.want(visit.key, visit.place, kMostUrgent);
        result_.coarsest_px = std::max(result_.coarsest_px, kMostUrgent);
        continue;
      }
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        const TilePlace& place = cache.children(layer).places[quadrant];
        if (!place.exists() || visit.key.size <= imagery.least_size) continue;
        const NodeKey key = visit.key.child(quadrant);
        KARST_ASSERT(depth < stack.size());
        stack[depth++] = {key, root_of(nodes, key), visit.low, visit.high, place};
      }
      continue;
    }
    NodeMeasure measure;
    measure.low = visit.low;
    measure.high = visit.high;
    const NodeBox box = node_box(info, measure, visit.key);
    const double texel_here = texel_voxels(info, visit.key.size);
    const double pixel = pixel_voxels(box, eye, camera.parallel, request.pixel);
    const std::int32_t layer = cache.find(visit.key);
    if (layer < 0) {
      // What is drawn instead is twice as coarse.
      const auto px = static_cast<float>(2 * texel_here / pixel);
      ++result_.lacking;
      if (needs(request, box, visit.key, texel_here, cache)) {
        cache.want(visit.key, visit.place, px);
      } else {
        ++result_.left_out;
      }
      result_.coarsest_px = std::max(result_.coarsest_px, px);
      continue;
    }
    if (texel_here <= pixel || visit.key.size <= imagery.least_size) continue;
    const ImageChildren& children = cache.children(layer);
    const bool split = visit.node >= 0 && nodes[static_cast<std::size_t>(visit.node)].is_split();
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (!children.places[quadrant].exists()) continue;
      const std::int32_t node =
          split ? nodes[static_cast<std::size_t>(visit.node)].first_child + quadrant : -1;
      KARST_ASSERT(depth < stack.size());
      stack[depth++] = {visit.key.child(quadrant), node, visit.low, visit.high, children.places[quadrant]};
    }
  }
}

void ImageView::make_table(const ImageCache& cache) {
  const bool same = made_ && made_version_ == cache.version() &&
                    std::equal(std::begin(made_centre_), std::end(made_centre_), place_.centre);
  if (same) return;
  made_ = true;
  made_version_ = cache.version();
  std::copy(std::begin(place_.centre), std::end(place_.centre), made_centre_);
  constexpr int kHalf = kImageWindow / 2;
  std::array<std::uint16_t, kImageWindowTiles> part{};
  for (int size = place_.root_size; size >= place_.least_size; --size) {
    const int first_x = (place_.centre[0] >> size) - kHalf;
    const int first_z = (place_.centre[1] >> size) - kHalf;
    const auto own =
        storage_.table.subspan(static_cast<std::size_t>(size) * kImageWindowTiles, kImageWindowTiles);
    if (size == place_.root_size) {
      part.fill(0);
    } else {
      // As the size above has it, one size coarser.
      const auto above =
          storage_.table.subspan(static_cast<std::size_t>(size + 1) * kImageWindowTiles, kImageWindowTiles);
      const int above_x = (place_.centre[0] >> (size + 1)) - kHalf;
      const int above_z = (place_.centre[1] >> (size + 1)) - kHalf;
      for (int z = 0; z < kImageWindow; ++z) {
        for (int x = 0; x < kImageWindow; ++x) {
          const std::uint16_t entry =
              above[entry_of(((first_x + x) >> 1) - above_x, ((first_z + z) >> 1) - above_z)];
          part[entry_of(x, z)] = static_cast<std::uint16_t>(entry == 0 ? 0 : entry + (1 << 10));
        }
      }
    }
    const std::span<const TileSlot> layers = cache.layers();
    for (std::size_t layer = 0; layer < layers.size(); ++layer) {
      const TileSlot& entry = layers[layer];
      if (!entry.used || entry.key.size != size) continue;
      const int x = entry.key.x - first_x;
      const int z = entry.key.z - first_z;
      if (x < 0 || z < 0 || x >= kImageWindow || z >= kImageWindow) continue;
      part[entry_of(x, z)] = static_cast<std::uint16_t>(layer + 1);
    }
    if (std::equal(part.begin(), part.end(), own.begin())) continue;
    std::copy(part.begin(), part.end(), own.begin());
    dirty_ |= 1u << size;
  }
}

int ImageView::take_size(std::span<const std::uint16_t>& part) {
  for (int size = 0; size < kImageSizes; ++size) {
    if ((dirty_ >> size & 1) == 0) continue;
    dirty_ &= ~(1u << size);
    part = storage_.table.subspan(static_cast<std::size_t>(size) * kImageWindowTiles, kImageWindowTiles);
    return size;
  }
  return -1;
}

}  // namespace karst::core
