// SPDX-License-Identifier: MIT
#include "terrain/edit/paint/edit_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "terrain/base/check.h"
#include "terrain/edit/brush.h"
#include "terrain/edit/reached_patches.h"

namespace karst::core {
namespace {

constexpr std::uint32_t kBlock = World::Paint::kBlock;
constexpr std::size_t kChannels = 4;
constexpr std::size_t kNoChannel = kChannels;
constexpr double kFar = 0x1p30;  // voxels
// The cell of the channels' materials; others go by their block, z << 32 | x.
constexpr std::uint64_t kMaterials = ~std::uint64_t{0};

using Texel = std::array<std::uint8_t, kChannels>;
static_assert(sizeof(Texel) == kBlendTexelBytes);
using Block = std::array<Texel, kBlock * kBlock>;

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

bool is_near(const glm::dvec3& v) {
  return std::abs(v.x) <= kFar && std::abs(v.y) <= kFar && std::abs(v.z) <= kFar;
}

Status check(const Edit& edit, const World& world) {
  const GroundInfo& ground = world.ground();
  if (ground.basis.is_curved() || ground.closes() || ground.is_cube())
    return {StatusCode::unsupported, "grounds on a curved basis cannot be painted", "ground"};
  if (world.materials().count == 0) return refuse("the world has no materials", "material");
  if (!world.is_paintable())
    return {StatusCode::limit_reached, "there is no painted map in the plan", "paint_width", 1};
  if (edit.material >= world.materials().count && edit.material != kNoPaint)
    return refuse("the world has no such material", "material");
  if (edit.shape == BrushShape::voxel || static_cast<int>(edit.shape) >= kBrushShapes)
    return refuse("not a shape of paint", "shape");
  if (!is_near(edit.place)) return refuse("not finite, or too far away", "place");
  if (edit.shape == BrushShape::capsule && !is_near(edit.to))
    return refuse("not finite, or too far away", "to");
  if (edit.shape == BrushShape::box) {
    if (!is_near(edit.half) || !(edit.half.x > 0 && edit.half.z > 0))
      return refuse("not a positive length, or too large", "half_m");
  } else if (!(edit.radius > 0 && edit.radius <= kFar)) {
    return refuse("not a positive length, or too large", "radius_m");
  }
  if (!(edit.amount >= 0 && edit.amount <= 1)) return refuse("not within 0..1", "amount");
  if (!(edit.hardness >= 0 && edit.hardness <= 1)) return refuse("not within 0..1", "hardness");
  return {};
}

// The brush from above.
Edit flattened(const Edit& edit) {
  Edit flat = edit;
  flat.place.y = flat.to.y = 0;
  flat.half.y = 1;
  return flat;
}

class PaintEdit {
 public:
  PaintEdit(World& world, const BlendSpan& span, const Edit& edit, UndoLog* log)
      : paint_(world.paint()), span_(span), edit_(flattened(edit)), log_(log) {}

  Status run(PaintChange& change) {
    if (edit_.material != kNoPaint) {
      channel_ = channel();
      if (channel_ == kNoChannel)
        return refuse("four others are painted already: wipe one of them away", "material");
    }
    const TexelRect rect = reached();
    for (std::uint32_t z = rect.low.y / kBlock; z * kBlock < rect.high.y; ++z) {
      for (std::uint32_t x = rect.low.x / kBlock; x * kBlock < rect.high.x; ++x) paint_block(x, z, change);
    }
    return {};
  }

 private:
  std::uint32_t side(int axis) const { return axis == 0 ? paint_.map->width : paint_.map->depth; }

  // The material's, or one that is free, or one without a weight anywhere.
  std::size_t channel() const {
    const auto& materials = paint_.map->materials;
    for (const int wanted : {edit_.material + 1, 0}) {
      for (std::size_t c = 0; c < kChannels; ++c) {
        if (materials[c] == wanted) return c;
      }
    }
    bool used[kChannels] = {};
    for (std::size_t at = 0; at < paint_.texels.size(); ++at)
      used[at % kChannels] |= paint_.texels[at] != std::byte{0};
    for (std::size_t c = 0; c < kChannels; ++c) {
      if (!used[c]) return c;
    }
    return kNoChannel;
  }

  double place(int axis, std::uint32_t texel) const {
    return span_.low[axis] + (texel + 0.5) * span_.size[axis] / side(axis);
  }

  // Texels that the brush may reach, of which there may be none.
  TexelRect reached() const {
    const BrushBox box = brush_box(edit_);
    TexelRect rect;
    for (int axis = 0; axis < 2; ++axis) {
      const double most = side(axis);
      const auto at = [&](double voxels) { return (voxels - span_.low[axis]) / span_.size[axis] * most; };
      rect.low[axis] =
          static_cast<std::uint32_t>(std::clamp(std::floor(at(box.low[2 * axis])) - 1, 0.0, most));
      rect.high[axis] =
          static_cast<std::uint32_t>(std::clamp(std::ceil(at(box.high[2 * axis])) + 1, 0.0, most));
    }
    return rect.exists() ? rect : TexelRect{};
  }

  Texel painted(const Texel& before, double share) const {
    Texel after = before;
    unsigned sum = 0;
    for (std::size_t c = 0; c < kChannels; ++c) {
      const double towards = c == channel_ ? 255 : 0;
      double way = (towards - before[c]) * share;
      // What could begin to paint a texel goes on to the end, a step at a time at least.
      if (255 * share >= 0.5 && std::abs(way) <= 0.5 && before[c] != towards) way = towards > 0 ? 1 : -1;
      after[c] = static_cast<std::uint8_t>(std::floor(before[c] + way + 0.5));
      sum += after[c];
    }
    // Rounded up more often than down.
    for (; sum > 255 && channel_ != kNoChannel; --sum) {
      std::size_t most = channel_ == 0 ? 1 : 0;
      for (std::size_t c = 0; c < kChannels; ++c) {
        if (c != channel_ && after[c] > after[most]) most = c;
      }
      if (after[most] == 0) break;
      --after[most];
    }
    return after;
  }

  std::byte* texel(std::uint32_t x, std::uint32_t z) const {
    return paint_.texels.data() + (std::size_t{z} * paint_.map->width + x) * kBlendTexelBytes;
  }

  void paint_block(std::uint32_t block_x, std::uint32_t block_z, PaintChange& change) {
    const TexelRect own{
        {block_x * kBlock, block_z * kBlock},
        {std::min((block_x + 1) * kBlock, side(0)), std::min((block_z + 1) * kBlock, side(1))}};
    Block before{}, after{};
    bool changed = false;
    for (std::uint32_t z = own.low.y; z < own.high.y; ++z) {
      for (std::uint32_t x = own.low.x; x < own.high.x; ++x) {
        const std::size_t at = (z - own.low.y) * kBlock + x - own.low.x;
        std::memcpy(&before[at], texel(x, z), sizeof(Texel));
        const double weight = brush_weight(edit_, {place(0, x), 0, place(1, z)});
        after[at] = weight > 0 ? painted(before[at], weight * edit_.amount) : before[at];
        changed = changed || after[at] != before[at];
      }
    }
    if (!changed) return;
    if (!change.changed) take_channel(change);
    const std::size_t blocks = (paint_.map->width + kBlock - 1) / kBlock;
    keep(std::uint64_t{block_z} << 32 | block_x, block_z * blocks + block_x,
         std::as_bytes(std::span(before)));
    change.changed = true;
    change.texels.join(own);
    for (std::uint32_t z = own.low.y; z < own.high.y; ++z) {
      std::memcpy(texel(own.low.x, z), &after[(z - own.low.y) * kBlock],
                  (own.high.x - own.low.x) * sizeof(Texel));
    }
  }

  void take_channel(PaintChange& change) {
    if (channel_ == kNoChannel || paint_.map->materials[channel_] == edit_.material + 1) return;
    keep(kMaterials, paint_.kept.size() - 1, std::as_bytes(std::span(paint_.map->materials)));
    paint_.map->materials[channel_] = static_cast<std::uint8_t>(edit_.material + 1);
    change.materials = true;
  }

  // Once a cell and part.
  void keep(std::uint64_t key, std::size_t mark, std::span<const std::byte> before) {
    if (log_ == nullptr) return;
    if (log_->open_part() != CellKind::paint) log_->begin_part();
    const auto part = [&] { return static_cast<std::uint32_t>(log_->part_number()); };
    if (log_->open_part() == CellKind::paint && paint_.kept[mark] == part()) return;
    log_->add(CellKind::paint, key, before);
    paint_.kept[mark] = part();
  }

  World::Paint paint_;
  const BlendSpan& span_;
  Edit edit_;
  UndoLog* log_;
  std::size_t channel_ = kNoChannel;  // that is painted; none: all are wiped
};

bool mark(World::Paint& paint, const BlendSpan& span, const WorldPart& part, PatchId id) {
  std::uint8_t& given = paint.overrides[part.first + id];
  if (given != 0 && given != kPaintedByMap) return false;
  const LatticeBox box = patch_box(part.surface, part.bounds, id);
  const auto side = [&](const glm::ivec3& end) {
    return glm::dvec2(part.corner.x + end.x / double{kStepsPerVoxel},
                      part.corner.z + end.z / double{kStepsPerVoxel});
  };
  const TexelRect rect = texels_reaching(*paint.map, span, side(box.min), side(box.max));
  const std::uint8_t now = is_painted(*paint.map, paint.texels, rect) ? kPaintedByMap : std::uint8_t{0};
  const bool changed = now != given;
  given = now;
  return changed;
}

// Of the patches that these texels reach.
bool mark_around(World& world, const BlendSpan& span, const TexelRect& texels) {
  if (world.patch_count() == 0 || !texels.exists()) return false;
  World::Paint paint = world.paint();
  const glm::dvec2 texel(span.size.x / paint.map->width, span.size.y / paint.map->depth);
  const double reach = kBlendReach + 1;
  const glm::dvec2 low = span.low + (glm::dvec2(texels.low) - reach) * texel;
  const glm::dvec2 high = span.low + (glm::dvec2(texels.high) + reach) * texel;
  bool changed = false;
  for (const WorldPart& part : world.parts()) {
    const glm::dvec2 corner(part.corner.x, part.corner.z);
    const glm::dvec2 least = (low - corner) * double{kStepsPerVoxel};
    const glm::dvec2 most = (high - corner) * double{kStepsPerVoxel};
    const auto reaches = [&](const LatticeBox& box) {
      return box.min.x <= most.x && box.max.x >= least.x && box.min.z <= most.y && box.max.z >= least.y;
    };
    const auto visit = [&](PatchId id) { changed = mark(paint, span, part, id) || changed; };
    ReachedPatches{*part.tree, part.surface, part.bounds, reaches, visit}.run();
  }
  return changed;
}

}  // namespace

BlendSpan blend_span(const WorldInfo& info, const GroundInfo& ground) {
  if (!ground.exists()) return BlendSpan::of_voxels(info.extent);
  BlendSpan span;
  for (int axis = 0; axis < 2; ++axis) {
    span.low[axis] = static_cast<double>(ground.corner[axis]) * kVertexStep / kStepsPerVoxel;
    span.size[axis] = static_cast<double>(ground.samples[axis] - 1) * ground.steps[axis] / kStepsPerVoxel;
  }
  return span;
}

Status edit_paint(World& world, const BlendSpan& span, const Edit& edit, UndoLog* log, PaintChange& change) {
  change = {};
  if (const Status status = check(edit, world); !status.ok()) return status;
  if (const Status status = PaintEdit(world, span, edit, log).run(change); !status.ok()) return status;
  change.patches = mark_around(world, span, change.texels);
  return {};
}

void exchange_paint(World& world, const BlendSpan& span, UndoPart part, PaintChange& change) {
  change = {};
  const World::Paint paint = world.paint();
  for (const UndoCell cell : part) {
    change.changed = true;
    if (cell.key == kMaterials) {
      KARST_ASSERT(cell.bytes.size() == sizeof paint.map->materials);
      std::swap_ranges(cell.bytes.begin(), cell.bytes.end(),
                       reinterpret_cast<std::byte*>(paint.map->materials));
      change.materials = true;
      continue;
    }
    KARST_ASSERT(cell.bytes.size() == sizeof(Block));
    const auto x = static_cast<std::uint32_t>(cell.key) * kBlock;
    const auto z = static_cast<std::uint32_t>(cell.key >> 32) * kBlock;
    const TexelRect own{{x, z},
                        {std::min(x + kBlock, paint.map->width), std::min(z + kBlock, paint.map->depth)}};
    const std::size_t row = (own.high.x - x) * sizeof(Texel);
    for (std::uint32_t k = z; k < own.high.y; ++k) {
      std::byte* const there =
          paint.texels.data() + (std::size_t{k} * paint.map->width + x) * kBlendTexelBytes;
      std::swap_ranges(there, there + row, cell.bytes.data() + (k - z) * kBlock * sizeof(Texel));
    }
    change.texels.join(own);
  }
  change.patches = mark_around(world, span, change.texels);
}

bool mark_painted(World& world, const BlendSpan& span, std::span<const PatchId> patches) {
  World::Paint paint = world.paint();
  bool changed = false;
  for (const PatchId patch : patches) {
    const WorldPart& part = world.part_of(patch);
    changed = mark(paint, span, part, patch - part.first) || changed;
  }
  return changed;
}

}  // namespace karst::core
