// SPDX-License-Identifier: MIT
// What edits have to do with regions of the ground.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "terrain/base/check.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

bool overlap(const GridRect& a, const GridRect& b) {
  for (int axis = 0; axis < 2; ++axis) {
    if (a.high[axis] < b.low[axis] || b.high[axis] < a.low[axis]) return false;
  }
  return a.exists() && b.exists();
}

// Of a growth, what the log keeps.
struct GrowthCell {
  double error, way, stretch;
};

}  // namespace

std::uint32_t EditGround::regions_with(const GridRect& samples) const {
  std::uint32_t with = 0;
  for (std::size_t n = 0; n < info_.regions().size(); ++n) {
    if (overlap(samples, samples_of(info_.regions()[n]))) with |= 1u << n;
  }
  return with;
}

std::uint32_t EditGround::regions_reached(const Edit& edit) const {
  return regions_with(footprint(edit));
}

// The ground beneath a region is what stands for it, and what it was measured against.
Status EditGround::check_regions(const GridRect& samples, bool beneath) const {
  const std::uint32_t with = regions_with(samples);
  if (with == 0 || (beneath && (with & ~reserved_) == 0)) return {};
  return {StatusCode::limit_reached, "heights where a region stands take room for edits of its patches",
          "edit_patches", 1};
}

// Of nodes of sizes from 1 on.
Status EditGround::add_region(const GroundInfo& info) {
  const GroundInfo before = info_;
  info_.region_count = info.region_count;
  info_.region_list = info.region_list;
  const std::size_t region = info_.regions().size() - 1;
  growths_[region] = {};
  reserved_ &= ~(1u << region);
  const Status status = reserve_region(region);
  if (!status.ok()) info_.region_count = before.region_count;
  return status;
}

void EditGround::drop_region(const GroundInfo& info) {
  reserved_ &= ~(1u << (info_.regions().size() - 1));
  info_.region_count = info.region_count;
  info_.region_list = info.region_list;
}

Status EditGround::reserve_region(std::size_t region) {
  if (is_reserved(region)) return {};
  if (const Status status = reserve(samples_of(info_.regions()[region]), 1); !status.ok()) return status;
  if (const Status status = find_error(region, errors_[region]); !status.ok()) return status;
  reserved_ |= 1u << region;
  return {};
}

// Thresholds hold k error and more, whatever else they hold.
Status EditGround::find_error(std::size_t region, double& error) {
  const GroundRegion& of = info_.regions()[region];
  error = std::numeric_limits<double>::infinity();
  constexpr int kLast = kDemands - 1;
  for (int size = 1; size <= info_.top_size() && !std::isfinite(error); ++size) {
    const GridRect nodes = nodes_with(info_, size, samples_of(of));
    for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
      for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
        const NodeKey node{size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
        if (in_region(of, node) != InRegion::part) continue;
        const Tile* tile = nullptr;
        if (const Status status = file_.get(tile_of(node), tile); !status.ok()) return status;
        const std::uint16_t half = tile->nodes[node_in_tile(node)].thresholds[kLast];
        if (half >= kNeverMorphs) continue;
        const double steps = std::ldexp(double{threshold_steps(half)}, info_.page_size(size));
        error = std::min(error, steps / demand(kLast));
      }
    }
  }
  return {};
}

// Of nodes of a size that are few.
int EditGround::size_beneath(std::size_t region) const {
  constexpr std::int64_t kMost = 16;
  const GridRect samples = samples_of(info_.regions()[region]);
  int size = 1;
  while (size < info_.top_size() &&
         std::max(samples.high[0] - samples.low[0], samples.high[1] - samples.low[1]) >
             (kMost * kNodeQuads << size)) {
    ++size;
  }
  return size;
}

std::uint32_t EditGround::regions_looking_at(const GridRect& samples) const {
  std::uint32_t all = 0;
  for (std::size_t n = 0; n < info_.regions().size(); ++n) {
    if (!is_reserved(n)) continue;
    const int size = size_beneath(n);
    const GridRect beneath = nodes_with(info_, size, samples_of(info_.regions()[n]));
    if (overlap(nodes_with(info_, size, samples), beneath)) all |= 1u << n;
  }
  return all;
}

void EditGround::heights_beneath(std::size_t region, std::int32_t& low, std::int32_t& high) const {
  KARST_ASSERT(is_reserved(region));
  const GridRect samples = samples_of(info_.regions()[region]);
  const int size = size_beneath(region);
  low = std::numeric_limits<std::int32_t>::max();
  high = std::numeric_limits<std::int32_t>::min();
  const GridRect nodes = nodes_with(info_, size, samples);
  for (std::int64_t z = nodes.low[1]; z <= nodes.high[1]; ++z) {
    for (std::int64_t x = nodes.low[0]; x <= nodes.high[0]; ++x) {
      const NodeKey node{size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
      const NodeMeasure& own = overlay_.find(tile_of(node))->tile.nodes[node_in_tile(node)];
      low = std::min(low, own.low);
      high = std::max(high, own.high);
    }
  }
}

void EditGround::grow_region(std::size_t region, const RegionGrowth& growth, UndoLog* log,
                             GroundChange& change) {
  KARST_ASSERT(is_reserved(region));
  change = {};
  RegionGrowth& own = growths_[region];
  const RegionGrowth before = own;
  const GrowthCell kept{before.error, before.way, before.stretch};
  own = growth;
  if (log != nullptr && (kept.error != own.error || kept.way != own.way || kept.stretch != own.stretch)) {
    log->begin_part();
    log->add(CellKind::region_growth, region, std::as_bytes(std::span(&kept, 1)));
  }
  const bool same = before.exists() == own.exists() && before.now.error == own.now.error &&
                    before.now.reach == own.now.reach;
  if (same) return;
  change.changed = true;
  change.stamp = ++stamp_;
  wait(samples_of(info_.regions()[region]), 1);
  if (!own.exists()) return;
  MeasureEdits measure(info_, overlay_, file_, blocks_.scratch[0].measure, growths(), stamp_);
  measure.grow(region);
  trouble_ = measure.trouble();
  count_tiles(change);
}

void EditGround::restore_growth(std::size_t region, const RegionGrowth& growth) {
  KARST_ASSERT(is_reserved(region));
  growths_[region] = growth;
  wait(samples_of(info_.regions()[region]), 1);
}

std::size_t EditGround::exchange_growth(UndoPart part) {
  const UndoCell cell = *part.begin();
  GrowthCell kept;
  KARST_ASSERT(cell.kind == CellKind::region_growth && cell.bytes.size() == sizeof kept);
  const auto region = static_cast<std::size_t>(cell.key);
  RegionGrowth& own = growths_[region];
  std::memcpy(&kept, cell.bytes.data(), sizeof kept);
  const GrowthCell now{own.error, own.way, own.stretch};
  std::memcpy(cell.bytes.data(), &now, sizeof now);
  own.error = kept.error;
  own.way = kept.way;
  own.stretch = kept.stretch;
  return region;
}

}  // namespace karst::core
