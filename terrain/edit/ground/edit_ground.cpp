// SPDX-License-Identifier: MIT
#include "terrain/edit/ground/edit_ground.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/edit/brush.h"
#include "terrain/lod/morph.h"
#include "terrain/nodes/make_node.h"

namespace karst::core {
namespace {

constexpr int kTileLog = 4;  // a node of this size is a tile of size 0 wide
static_assert(kTileNodes == 1 << kTileLog);
// Heights of a voxel.
constexpr double kUnits = static_cast<double>(kStepsPerVoxel) / kVertexStep;
// Least y of a plane's normal, of length 1: steeper planes are no ground.
constexpr double kLeastUp = 0.01;
// Steps of a node's size from its origin to a vertex, as MakeNode clamps.
constexpr std::int64_t kMostFromOrigin = 32'766 - 16;

bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

GridRect within(const GridRect& a, const GridRect& b) {
  GridRect both;
  for (int axis = 0; axis < 2; ++axis) {
    both.low[axis] = std::max(a.low[axis], b.low[axis]);
    both.high[axis] = std::min(a.high[axis], b.high[axis]);
  }
  return both;
}

}  // namespace

Status EditGround::check(const Edit& edit) const {
  const auto wrong = [](const char* what, const char* field) {
    return Status(StatusCode::invalid_argument, what, field);
  };
  switch (edit.tool) {
    case EditTool::extrude:
    case EditTool::smooth:
    case EditTool::noise:
    case EditTool::flatten:
    case EditTool::level:
      break;
    default:
      return wrong("not a tool of heights", "tool");
  }
  if (edit.shape == BrushShape::voxel || static_cast<int>(edit.shape) >= kBrushShapes)
    return wrong("not a shape of heights", "shape");
  if (!is_finite(edit.place)) return wrong("not a place", "place");
  if (edit.shape == BrushShape::capsule && !is_finite(edit.to)) return wrong("not a place", "to");
  const glm::dvec3& half = edit.half;
  if (edit.shape == BrushShape::box) {
    if (!is_finite(half) || !(half.x > 0 && half.y > 0 && half.z > 0))
      return wrong("not a positive length", "half_m");
  } else if (!(edit.radius > 0) || !std::isfinite(edit.radius)) {
    return wrong("not a positive length", "radius_m");
  }
  if (!std::isfinite(edit.strength)) return wrong("not a length", "strength_m");
  if (!(edit.amount >= 0 && edit.amount <= 1)) return wrong("not from 0 to 1", "amount");
  if (!(edit.hardness >= 0 && edit.hardness <= 1)) return wrong("not from 0 to 1", "hardness");
  if (edit.tool == EditTool::noise && (!(edit.wave > 0) || !std::isfinite(edit.wave)))
    return wrong("not a positive length", "wave_m");
  if (edit.tool == EditTool::flatten) {
    const double length = std::sqrt(glm::dot(edit.up, edit.up));
    if (!is_finite(edit.up) || !std::isfinite(length) || !(edit.up.y > kLeastUp * length))
      return wrong("does not point up", "up");
  }
  if (info_.basis.is_curved() || info_.closes() || info_.is_cube())
    return {StatusCode::unsupported, "grounds on a curved basis cannot be edited", "ground"};
  return {};
}

// Samples that a brush may reach.
GridRect EditGround::footprint(const Edit& edit) const {
  const BrushBox box = brush_box(edit);
  GridRect samples;
  for (int axis = 0; axis < 2; ++axis) {
    const auto last = static_cast<double>(info_.samples[axis] - 1);
    const auto index = [&](double voxels) {
      return (voxels * kUnits - static_cast<double>(info_.corner[axis])) * kVertexStep / info_.steps[axis];
    };
    // One more for rounding; a brush beside the ground is beyond both ends.
    const double low = std::clamp(std::floor(index(box.low[2 * axis])) - 1, -1.0, last + 1);
    const double high = std::clamp(std::ceil(index(box.high[2 * axis])) + 1, -1.0, last + 1);
    samples.low[axis] = static_cast<std::int64_t>(std::max(low, 0.0));
    samples.high[axis] = static_cast<std::int64_t>(std::min(high, last));
  }
  return samples;
}

// The tile of size 0 that has a sample as its own.
std::int64_t EditGround::owner(int axis, std::int64_t sample) const {
  return std::min(sample / kTileQuads, (nodes_along(info_, axis, 0) - 1) / kTileNodes);
}

Status EditGround::current(NodeKey key, const Tile*& tile) {
  if (const EditedTile* const there = overlay_.find(key); there != nullptr) {
    tile = &there->tile;
    return {};
  }
  return file_.get(key, tile);
}

// The height of sample (i, k), which is (at_i, at_k) in the tile; kVertexStep, not rounded.
double EditGround::edited(const Edit& edit, const Tile& tile, std::int64_t i, std::int64_t k, int at_i,
                          int at_k) const {
  const double height = tile.height(at_i, at_k);
  const glm::dvec3 place(static_cast<double>(sample_place(info_, 0, i)) / kUnits, height / kUnits,
                         static_cast<double>(sample_place(info_, 1, k)) / kUnits);
  const double weight = brush_weight(edit, place);
  if (weight <= 0) return height;
  const auto towards = [&](double other) { return height + weight * edit.amount * (other - height); };
  switch (edit.tool) {
    case EditTool::extrude:
      return height + weight * edit.strength * kUnits;
    case EditTool::noise:
      return height + weight * edit.strength * kUnits * simplex_noise(place / edit.wave, edit.seed);
    case EditTool::smooth: {
      std::int64_t sum = 0;
      for (int dk = -1; dk <= 1; ++dk) {
        for (int di = -1; di <= 1; ++di) sum += tile.height(at_i + di, at_k + dk);
      }
      return towards(static_cast<double>(sum - tile.height(at_i, at_k)) / 8);
    }
    case EditTool::flatten: {
      const double rise =
          (edit.up.x * (place.x - edit.place.x) + edit.up.z * (place.z - edit.place.z)) / edit.up.y;
      return towards((edit.place.y - rise) * kUnits);
    }
    default:
      return towards(edit.place.y * kUnits);
  }
}

// Vertices of a tile of size 0, 0 .. kTileQuads, that its nodes with some of the samples have.
GridRect EditGround::vertices_of(NodeKey tile, const GridRect& samples) const {
  const GridRect nodes = nodes_with(info_, 0, samples);
  GridRect out;
  const std::int64_t first[2] = {tile.x, tile.z};
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t begin = first[axis] * kTileNodes;
    out.low[axis] = (std::max(nodes.low[axis], begin) - begin) * kNodeQuads;
    out.high[axis] = (std::min(nodes.high[axis] + 1, begin + kTileNodes) - begin) * kNodeQuads;
    out.high[axis] = std::min(out.high[axis], info_.samples[axis] - 1 - first[axis] * kTileQuads);
  }
  return out;
}

// Heights to be of those vertices.
Status EditGround::make_fresh(const Edit& edit, NodeKey key, const Tile& tile, const GridRect& samples) {
  std::int32_t* const fresh = blocks_.scratch[0].fresh;
  const GridRect vertices = vertices_of(key, samples);
  for (std::int64_t k = vertices.low[1]; k <= vertices.high[1]; ++k) {
    for (std::int64_t i = vertices.low[0]; i <= vertices.high[0]; ++i) {
      const double height =
          std::floor(edited(edit, tile, key.x * std::int64_t{kTileQuads} + i,
                            key.z * std::int64_t{kTileQuads} + k, static_cast<int>(i), static_cast<int>(k)) +
                     0.5);
      if (!(height >= -kMostHeight && height <= kMostHeight)) {
        return {StatusCode::invalid_argument, "heights would be beyond what a ground holds, 16,384 voxels",
                "strength_m"};
      }
      fresh[k * (kTileQuads + 1) + i] = static_cast<std::int32_t>(height);
    }
  }
  return {};
}

namespace {

// Whether vertices of a node whose samples lie between low and high can be stored around its origin.
bool fits(const GroundInfo& info, NodeKey node, std::int32_t low, std::int32_t high) {
  NodeMeasure measure;
  measure.low = low;
  measure.high = high;
  const int size = info.page_size(node.size);
  const std::int64_t origin = std::int64_t{node_origin(info, measure, node).y} * kStepsPerVoxel;
  return place_at_size(high, size) * kVertexStep - origin <= kMostFromOrigin &&
         place_at_size(low, size) * kVertexStep - origin >= -kMostFromOrigin;
}

Status too_steep() {
  return {StatusCode::invalid_argument, "the ground would be too steep, 8 voxels from one sample to the next",
          "strength_m"};
}

}  // namespace

// What an edit would change, and whether it may.
Status EditGround::try_out(const Edit& edit, const GridRect& samples, GroundChange& change) {
  const std::int32_t* const fresh = blocks_.scratch[0].fresh;
  const GridRect nodes = nodes_with(info_, 0, samples);
  for (std::int64_t tz = nodes.low[1] / kTileNodes; tz <= nodes.high[1] / kTileNodes; ++tz) {
    for (std::int64_t tx = nodes.low[0] / kTileNodes; tx <= nodes.high[0] / kTileNodes; ++tx) {
      const NodeKey key{0, static_cast<std::int32_t>(tx), static_cast<std::int32_t>(tz)};
      const Tile* tile = nullptr;
      if (const Status status = current(key, tile); !status.ok()) return status;
      if (const Status status = make_fresh(edit, key, *tile, samples); !status.ok()) return status;
      const auto to_be = [&](std::int64_t i, std::int64_t k) { return fresh[k * (kTileQuads + 1) + i]; };
      const GridRect vertices = vertices_of(key, samples);
      for (std::int64_t k = vertices.low[1]; k <= vertices.high[1]; ++k) {
        for (std::int64_t i = vertices.low[0]; i <= vertices.high[0]; ++i) {
          const std::int32_t before = tile->height(static_cast<int>(i), static_cast<int>(k));
          const std::int64_t x = tx * kTileQuads + i, z = tz * kTileQuads + k;
          if (to_be(i, k) == before || owner(0, x) != tx || owner(1, z) != tz) continue;
          if (!change.samples.exists()) change.least = change.greatest = before;
          change.samples.take(x, z);
          change.least = std::min({change.least, before, to_be(i, k)});
          change.greatest = std::max({change.greatest, before, to_be(i, k)});
        }
      }
      for (std::int64_t k = vertices.low[1]; k < vertices.high[1]; k += kNodeQuads) {
        for (std::int64_t i = vertices.low[0]; i < vertices.high[0]; i += kNodeQuads) {
          std::int32_t low = to_be(i, k), high = low;
          for (std::int64_t z = k; z <= std::min(k + kNodeQuads, vertices.high[1]); ++z) {
            for (std::int64_t x = i; x <= std::min(i + kNodeQuads, vertices.high[0]); ++x) {
              low = std::min(low, to_be(x, z));
              high = std::max(high, to_be(x, z));
            }
          }
          const NodeKey node{0, static_cast<std::int32_t>(tx * kTileNodes + i / kNodeQuads),
                             static_cast<std::int32_t>(tz * kTileNodes + k / kNodeQuads)};
          if (!fits(info_, node, low, high)) return too_steep();
        }
      }
    }
  }
  return {};
}

// All tiles that may change, as they are.
Status EditGround::reserve(const GridRect& samples, int least_size) {
  for (const bool counts : {true, false}) {
    std::uint64_t more = 0;
    for (int size = least_size; size <= info_.top_size(); ++size) {
      const GridRect tiles = tiles_around(info_, size, samples);
      for (std::int64_t z = tiles.low[1]; z <= tiles.high[1]; ++z) {
        for (std::int64_t x = tiles.low[0]; x <= tiles.high[0]; ++x) {
          const NodeKey key{size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
          if (overlay_.find(key) != nullptr) continue;
          ++more;
          if (counts) continue;
          const Tile* tile = nullptr;
          if (const Status status = file_.get(key, tile); !status.ok()) return status;
          overlay_.add(key, *tile);
        }
      }
    }
    if (counts && more > overlay_.room()) {
      return {StatusCode::limit_reached, "edits reach more tiles of the ground than there is room for",
              "edit_tiles", overlay_.tiles().size() + more};
    }
  }
  return {};
}

// Of sizes from 1 on, by what their nodes may span at most; where that is too much, of nodes within a tile of
// size 0 by what they will.
Status EditGround::check_fit(const Edit& edit, const GroundChange& change) {
  const auto may_span = [&](NodeKey node) {
    const NodeMeasure& own = overlay_.find(tile_of(node))->tile.nodes[node_in_tile(node)];
    return fits(info_, node, std::min(own.low, change.least), std::max(own.high, change.greatest));
  };
  const GridRect finest = nodes_with(info_, 0, change.samples);
  for (std::int64_t tz = finest.low[1] / kTileNodes; tz <= finest.high[1] / kTileNodes; ++tz) {
    for (std::int64_t tx = finest.low[0] / kTileNodes; tx <= finest.high[0] / kTileNodes; ++tx) {
      const NodeKey key{0, static_cast<std::int32_t>(tx), static_cast<std::int32_t>(tz)};
      bool is_made = false;
      for (int size = 1; size <= std::min(kTileLog, info_.top_size()); ++size) {
        const int wide = kTileNodes >> size;
        const GridRect nodes = within(nodes_with(info_, size, change.samples),
                                      {{tx * wide, tz * wide}, {tx * wide + wide - 1, tz * wide + wide - 1}});
        for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
          for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
            const NodeKey node{size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
            if (may_span(node)) continue;
            const Tile& tile = overlay_.find(key)->tile;
            if (!is_made) {
              const Status status = make_fresh(edit, key, tile, change.samples);
              KARST_ASSERT(status.ok());
            }
            is_made = true;
            if (!will_fit(key, tile, node, change.samples)) return too_steep();
          }
        }
      }
    }
  }
  for (int size = kTileLog + 1; size <= info_.top_size(); ++size) {
    const GridRect nodes = nodes_with(info_, size, change.samples);
    for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
      for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
        if (!may_span({size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)})) return too_steep();
      }
    }
  }
  return {};
}

// A node within a tile of size 0, by the heights to be of the tile's vertices.
bool EditGround::will_fit(NodeKey key, const Tile& tile, NodeKey node, const GridRect& samples) const {
  const std::int32_t* const fresh = blocks_.scratch[0].fresh;
  const GridRect vertices = vertices_of(key, samples);
  const int wide = kNodeQuads << node.size;
  const std::int64_t first[2] = {node.x * std::int64_t{wide} - key.x * std::int64_t{kTileQuads},
                                 node.z * std::int64_t{wide} - key.z * std::int64_t{kTileQuads}};
  const std::int64_t last[2] = {
      std::min(first[0] + wide, info_.samples[0] - 1 - key.x * std::int64_t{kTileQuads}),
      std::min(first[1] + wide, info_.samples[1] - 1 - key.z * std::int64_t{kTileQuads})};
  std::int32_t low = std::numeric_limits<std::int32_t>::max();
  std::int32_t high = std::numeric_limits<std::int32_t>::min();
  for (std::int64_t k = first[1]; k <= last[1]; ++k) {
    for (std::int64_t i = first[0]; i <= last[0]; ++i) {
      const bool is_fresh =
          k >= vertices.low[1] && k <= vertices.high[1] && i >= vertices.low[0] && i <= vertices.high[0];
      const std::int32_t height =
          is_fresh ? fresh[k * (kTileQuads + 1) + i] : tile.height(static_cast<int>(i), static_cast<int>(k));
      low = std::min(low, height);
      high = std::max(high, height);
    }
  }
  return fits(info_, node, low, high);
}

// An edit goes on with the part before it where all that lies between them is there to be made anew, and is
// not much more than both.
void EditGround::choose_part(const GridRect& samples, UndoLog& log) {
  constexpr std::int64_t kMostTimes = 4;
  const auto area = [](const GridRect& rect) {
    return (rect.high[0] - rect.low[0] + 1) * (rect.high[1] - rect.low[1] + 1);
  };
  if (log.open_part() == CellKind::ground_samples) {
    GridRect both = part_samples_;
    both.take(samples.low[0], samples.low[1]);
    both.take(samples.high[0], samples.high[1]);
    bool joins = area(both) <= kMostTimes * (part_area_ + area(samples));
    for (int size = 0; size <= info_.top_size() && joins; ++size) {
      const GridRect tiles = tiles_around(info_, size, both);
      for (std::int64_t z = tiles.low[1]; z <= tiles.high[1]; ++z) {
        for (std::int64_t x = tiles.low[0]; x <= tiles.high[0]; ++x) {
          joins = joins && overlay_.find(
                               {size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)}) != nullptr;
        }
      }
    }
    if (joins) {
      part_samples_ = both;
      part_area_ += area(samples);
      return;
    }
  }
  log.begin_part();
  part_samples_ = samples;
  part_area_ = area(samples);
}

// Blocks of a tile that have changed samples, its own, which are as they were.
void EditGround::keep_blocks(EditedTile& edited, const GridRect& changed, UndoLog& log) const {
  const std::int32_t* const fresh = blocks_.scratch[0].fresh;
  const NodeKey key = edited.key;
  const std::int64_t first[2] = {key.x * std::int64_t{kTileQuads}, key.z * std::int64_t{kTileQuads}};
  std::int32_t block[kBlock * kBlock];
  for (std::int64_t z = changed.low[1] / kBlock; z <= changed.high[1] / kBlock; ++z) {
    for (std::int64_t x = changed.low[0] / kBlock; x <= changed.high[0] / kBlock; ++x) {
      const std::int64_t bit = 5 * (z - first[1] / kBlock) + x - first[0] / kBlock;
      if (log.open_part() != CellKind::none && edited.part == log.part_number() &&
          (edited.kept >> bit & 1u) != 0) {
        continue;
      }
      bool any = false;
      for (int k = 0; k < kBlock; ++k) {
        for (int i = 0; i < kBlock; ++i) {
          const std::int64_t at_i = x * kBlock + i - first[0], at_k = z * kBlock + k - first[1];
          const bool is_there = at_i <= kTileQuads && at_k <= kTileQuads;
          const std::int32_t before =
              is_there ? edited.tile.height(static_cast<int>(at_i), static_cast<int>(at_k)) : 0;
          block[k * kBlock + i] = before;
          const std::int64_t sample[2] = {first[0] + at_i, first[1] + at_k};
          const bool is_changed = sample[0] >= changed.low[0] && sample[0] <= changed.high[0] &&
                                  sample[1] >= changed.low[1] && sample[1] <= changed.high[1];
          any = any || (is_changed && fresh[at_k * (kTileQuads + 1) + at_i] != before);
        }
      }
      if (!any) continue;
      log.add(CellKind::ground_samples, static_cast<std::uint64_t>(z) << 32 | static_cast<std::uint64_t>(x),
              std::as_bytes(std::span(block)));
      if (edited.part != log.part_number()) edited.kept = 0;
      edited.part = log.part_number();
      edited.kept |= 1u << bit;
    }
  }
}

// Of tiles of size 0 their own samples; those of others in their rims stay as they are meanwhile.
void EditGround::set_heights(const Edit& edit, const GridRect& samples, UndoLog* log) {
  const std::int32_t* const fresh = blocks_.scratch[0].fresh;
  const GridRect nodes = nodes_with(info_, 0, samples);
  for (std::int64_t tz = nodes.low[1] / kTileNodes; tz <= nodes.high[1] / kTileNodes; ++tz) {
    for (std::int64_t tx = nodes.low[0] / kTileNodes; tx <= nodes.high[0] / kTileNodes; ++tx) {
      const NodeKey key{0, static_cast<std::int32_t>(tx), static_cast<std::int32_t>(tz)};
      EditedTile& edited = *overlay_.find(key);
      const Status status = make_fresh(edit, key, edited.tile, samples);
      KARST_ASSERT(status.ok());
      const GridRect vertices = vertices_of(key, samples);
      const auto each_changed = [&](const auto& visit) {
        for (std::int64_t k = vertices.low[1]; k <= vertices.high[1]; ++k) {
          for (std::int64_t i = vertices.low[0]; i <= vertices.high[0]; ++i) {
            const std::int64_t x = tx * kTileQuads + i, z = tz * kTileQuads + k;
            if (owner(0, x) != tx || owner(1, z) != tz) continue;
            std::int32_t& own = edited.tile.heights[(k + kTileRim) * kTileSide + i + kTileRim];
            const std::int32_t height = fresh[k * (kTileQuads + 1) + i];
            if (own != height) visit(own, height, x, z);
          }
        }
      };
      GridRect changed;
      if (log != nullptr) {
        each_changed([&](std::int32_t, std::int32_t, std::int64_t x, std::int64_t z) { changed.take(x, z); });
      }
      if (changed.exists()) keep_blocks(edited, changed, *log);
      each_changed([&](std::int32_t& own, std::int32_t height, std::int64_t, std::int64_t) {
        own = height;
        edited.stamp = stamp_;
      });
    }
  }
}

// Vertices of a size that are one of the samples, in all tiles that have them, from the tiles that own them.
void EditGround::set_sizes(int size, const GridRect& samples) {
  GridRect vertices;
  for (int axis = 0; axis < 2; ++axis) {
    const std::int64_t last = info_.samples[axis] - 1;
    const std::int64_t unit = std::int64_t{1} << size;
    // Beyond the ground's ends vertices are the last ones.
    vertices.low[axis] = samples.low[axis] == 0 ? -kTileRim : (samples.low[axis] + unit - 1) >> size;
    vertices.high[axis] = samples.high[axis] == last
                              ? (quads_along(info_, axis, size) / kTileQuads + 2) * kTileQuads
                              : samples.high[axis] >> size;
  }
  const GridRect tiles = tiles_around(info_, size, samples);
  for (std::int64_t tz = tiles.low[1]; tz <= tiles.high[1]; ++tz) {
    for (std::int64_t tx = tiles.low[0]; tx <= tiles.high[0]; ++tx) {
      EditedTile& edited =
          *overlay_.find({size, static_cast<std::int32_t>(tx), static_cast<std::int32_t>(tz)});
      GridRect all;
      const std::int64_t tile[2] = {tx, tz};
      for (int axis = 0; axis < 2; ++axis) {
        all.low[axis] = tile[axis] * kTileQuads - kTileRim;
        all.high[axis] = (tile[axis] + 1) * kTileQuads + kTileRim;
      }
      const GridRect own = within(all, vertices);
      const EditedTile* from = nullptr;
      NodeKey from_key{0, -1, -1};
      for (std::int64_t k = own.low[1]; k <= own.high[1]; ++k) {
        const std::int64_t z = sample_of(info_.samples[1], size, k);
        std::int32_t* out = edited.tile.heights + (k - all.low[1]) * kTileSide + (own.low[0] - all.low[0]);
        for (std::int64_t i = own.low[0]; i <= own.high[0]; ++i, ++out) {
          const std::int64_t x = sample_of(info_.samples[0], size, i);
          const NodeKey key{0, static_cast<std::int32_t>(owner(0, x)),
                            static_cast<std::int32_t>(owner(1, z))};
          if (!(key == from_key)) {
            from = overlay_.find(key);
            from_key = key;
          }
          const std::int32_t height =
              from->tile.height(static_cast<int>(x - key.x * std::int64_t{kTileQuads}),
                                static_cast<int>(z - key.z * std::int64_t{kTileQuads}));
          if (*out == height) continue;
          *out = height;
          edited.stamp = stamp_;
        }
      }
    }
  }
}

// All that follows from heights of size 0.
void EditGround::follow(GroundChange& change) {
  change.changed = true;
  change.stamp = stamp_;
  for (int size = 0; size <= info_.top_size(); ++size) set_sizes(size, change.samples);
  MeasureEdits measure(info_, overlay_, file_, blocks_.scratch[0].measure, growths(), stamp_);
  measure.run(change.samples, kExactAtOnce);
  wait(change.samples);
  change.measured = measure.measured();
  trouble_ = measure.trouble();
  const NodeMeasure& root = overlay_.find(tile_of({info_.top_size(), 0, 0}))->tile.nodes[0];
  info_.low = root.low;
  info_.high = root.high;
  count_tiles(change);
}

void EditGround::count_tiles(GroundChange& change) const {
  change.tiles =
      static_cast<std::uint32_t>(std::count_if(overlay_.tiles().begin(), overlay_.tiles().end(),
                                               [&](const EditedTile& tile) { return tile.stamp == stamp_; }));
}

Status EditGround::apply(const Edit& edit, UndoLog* log, GroundChange& change, bool beneath_regions) {
  KARST_ASSERT(exists());
  change = {};
  if (const Status status = check(edit); !status.ok()) return status;
  const GridRect samples = footprint(edit);
  if (!samples.exists()) return {};
  GroundChange planned;
  if (const Status status = try_out(edit, samples, planned); !status.ok()) return status;
  if (const Status status = check_regions(planned.samples, beneath_regions); !status.ok()) return status;
  if (!planned.samples.exists()) return {};
  if (const Status status = reserve(planned.samples); !status.ok()) return status;
  if (const Status status = check_fit(edit, planned); !status.ok()) return status;
  ++stamp_;
  change = planned;
  if (log != nullptr) choose_part(planned.samples, *log);
  set_heights(edit, planned.samples, log);
  follow(change);
  return {};
}

Status EditGround::height(std::int64_t i, std::int64_t k, std::int32_t& out) {
  const NodeKey key{0, static_cast<std::int32_t>(owner(0, i)), static_cast<std::int32_t>(owner(1, k))};
  const Tile* tile = nullptr;
  if (const Status status = current(key, tile); !status.ok()) return status;
  out = tile->height(static_cast<int>(i - key.x * std::int64_t{kTileQuads}),
                     static_cast<int>(k - key.z * std::int64_t{kTileQuads}));
  return {};
}

void EditGround::exchange(UndoCell cell, GroundChange& change) {
  KARST_ASSERT(cell.kind == CellKind::ground_samples && cell.bytes.size() == 4 * kBlock * kBlock);
  std::int32_t block[kBlock * kBlock];
  std::memcpy(block, cell.bytes.data(), sizeof block);
  const auto first_x = static_cast<std::int64_t>(cell.key & 0xffffffffu) * kBlock;
  const auto first_z = static_cast<std::int64_t>(cell.key >> 32) * kBlock;
  for (std::int64_t z = first_z; z < std::min(first_z + kBlock, info_.samples[1]); ++z) {
    for (std::int64_t x = first_x; x < std::min(first_x + kBlock, info_.samples[0]); ++x) {
      const NodeKey key{0, static_cast<std::int32_t>(owner(0, x)), static_cast<std::int32_t>(owner(1, z))};
      EditedTile* const edited = overlay_.find(key);
      // A block's own samples lie in one tile, but where the ground ends with a row of its own.
      if (edited == nullptr) continue;
      std::int32_t& own = edited->tile.heights[(z - key.z * std::int64_t{kTileQuads} + kTileRim) * kTileSide +
                                               (x - key.x * std::int64_t{kTileQuads}) + kTileRim];
      std::int32_t& other = block[(z - first_z) * kBlock + (x - first_x)];
      if (own == other) continue;
      if (!change.samples.exists()) change.least = change.greatest = own;
      change.samples.take(x, z);
      change.least = std::min({change.least, own, other});
      change.greatest = std::max({change.greatest, own, other});
      edited->stamp = stamp_;
      std::swap(own, other);
    }
  }
  std::memcpy(cell.bytes.data(), block, sizeof block);
}

void EditGround::exchange(UndoPart part, GroundChange& change) {
  change = {};
  ++stamp_;
  for (const UndoCell cell : part) exchange(cell, change);
  if (change.samples.exists()) follow(change);
}

SaveTiles EditGround::saving(const WorldReader& reader, WriteTile write) {
  const std::span<MeasureEdits::Scratch> room(&blocks_.scratch[0].measure, 1);
  return SaveTiles({info_, overlay_, file_, reader, write, std::as_writable_bytes(room)});
}

std::uint32_t EditGround::show(const GroundChange& change, Ground& ground) const {
  if (!change.changed) return 0;
  ground.set_heights(info_.low, info_.high);
  for (const EditedTile& tile : overlay_.tiles()) {
    if (tile.stamp == change.stamp) ground.replace(tile.key, tile.tile);
  }
  std::uint32_t nodes = 0;
  for (int size = 0; size <= info_.top_size() && change.samples.exists(); ++size) {
    // Vertices are stored from an origin by the node's heights; normals look at two vertices beside.
    GridRect with_rims = change.samples;
    for (int axis = 0; axis < 2; ++axis) {
      with_rims.low[axis] = std::max<std::int64_t>(with_rims.low[axis] - (std::int64_t{kTileRim} << size), 0);
      with_rims.high[axis] =
          std::min(with_rims.high[axis] + (std::int64_t{kTileRim} << size), info_.samples[axis] - 1);
    }
    const GridRect touched = nodes_with(info_, size, with_rims);
    for (std::int64_t z = touched.low[1] >> 1; z <= touched.high[1] >> 1; ++z) {
      for (std::int64_t x = touched.low[0] >> 1; x <= touched.high[0] >> 1; ++x) {
        nodes +=
            ground.remake_children({size + 1, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)});
      }
    }
  }
  return nodes;
}

}  // namespace karst::core
