// SPDX-License-Identifier: MIT
// New heights are made from the old ones, and counted; only then they are put in place. There is room for
// some whole patches; of others borders are kept, which may depend on other patches, and what is inside is
// made again: it depends on the patch's own heights alone. What a vertex gets follows from numbers that are
// the same bits in all patches that share it: its displaced place, its direction, and sums of heights that
// are integers.
#include "terrain/edit/patch/edit_heights.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/edit/brush.h"
#include "terrain/edit/patch/smooth_heights.h"
#include "terrain/edit/reached_patches.h"
#include "terrain/edit/shape/edit_shape.h"
#include "terrain/edit/shape/shape_undo.h"
#include "terrain/measure/measure_patches.h"
#include "terrain/patch/displacement.h"
#include "terrain/surface/patch_key.h"

namespace karst::core {
namespace {

using simd::Double2;

constexpr double kSteps = kStepsPerVoxel;

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

Status too_small(std::uint64_t patches) {
  return {StatusCode::limit_reached, "the brush reaches more patches than there is room for", "edit_patches",
          patches};
}

// As they lie in the patch's slot, made where there are none.
std::span<std::int16_t> current_heights(const World::Editable& all, PatchId patch) {
  const std::span<std::int16_t> heights = all.heights->block(all.first + patch);
  if (all.patches[patch].height_block == kNoHeights) std::ranges::fill(heights, std::int16_t{0});
  return heights;
}

void keep_heights(const World::Editable& all, PatchId patch, std::uint64_t key, UndoLog& log) {
  const PatchCell head{all.patches[patch].height_block != kNoHeights};
  const std::span<const std::byte> heights = std::as_bytes(current_heights(all, patch));
  const std::span<std::byte> room = log.add(CellKind::patch_heights, key, sizeof head + heights.size());
  if (room.empty()) return;  // the step is lost
  std::memcpy(room.data(), &head, sizeof head);
  std::ranges::copy(heights, room.begin() + sizeof head);
}

// Where two blocks of heights differ.
PatchExtent extent_of(std::span<const std::byte> kept, std::span<const std::int16_t> now, int level) {
  const auto side = static_cast<std::size_t>(patch_side(level));
  const std::span<const std::byte> bytes = std::as_bytes(now);
  PatchExtent extent;
  for (std::size_t j = 0; j < side; ++j) {
    const std::size_t row = j * side * sizeof(std::int16_t);
    if (std::memcmp(kept.data() + row, bytes.data() + row, side * sizeof(std::int16_t)) == 0) continue;
    for (std::size_t i = 0; i < side; ++i) {
      const std::size_t at = row + i * sizeof(std::int16_t);
      if (std::memcmp(kept.data() + at, bytes.data() + at, sizeof(std::int16_t)) != 0)
        extent.add(level, static_cast<int>(i), static_cast<int>(j));
    }
  }
  return extent;
}

class HeightsEdit {
 public:
  // edit: from the part's corner.
  HeightsEdit(World& world, std::size_t part, const Edit& edit)
      : all_(world.edit(part)),
        part_(static_cast<std::uint32_t>(part)),
        corner_(world.parts()[part].corner),
        room_(*all_.room),
        edit_(edit),
        level_(world.info().level),
        heights_(all_.heights->heights()),
        around_(all_.surface, heights_, level_),
        box_(brush_box(edit)),
        up_(edit.tool == EditTool::flatten ? glm::normalize(edit.up) : glm::dvec3(0, 1, 0)) {}

  // Makes new heights beside the old ones, of so many patches.
  Status plan(std::size_t& made) {
    made = 0;
    const std::uint64_t reached = count();
    if (reached > room_.patches.size()) return too_small(reached);
    for_each_reached([&](PatchId patch) {
      if (!make(patch, fresh(made), room_.extents[made])) return;
      for_each_border([&](std::size_t vertex, std::size_t n) { border(made)[n] = fresh(made)[vertex]; });
      room_.changed[made++] = patch;
    });
    // Patches and those around them.
    std::span<const PatchId> touched;
    if (!find_touched(all_.surface, room_.changed.first(made), room_.touched, touched).ok())
      return too_small(3 * made + 4);
    return {};
  }

  Status run(UndoLog* log, EditChange& change) {
    std::size_t made = 0;
    if (const Status status = plan(made); !status.ok() || made == 0) return status;
    const std::span<const PatchId> changed = room_.changed.first(made);
    if (log != nullptr) keep(changed, *log);
    change.changed = true;
    FollowChange follow(all_, level_, change);
    change.box = follow.box_before(changed[0]);
    for (std::size_t n = made; n-- > 0;) {
      if (n >= World::EditRoom::kWhole) {
        PatchExtent again;
        make(changed[n], fresh(n), again);
        for_each_border([&](std::size_t vertex, std::size_t k) { fresh(n)[vertex] = border(n)[k]; });
      }
      put_heights(all_, changed[n], fresh(n));
    }
    follow.run(changed, {}, room_.extents.first(made), false);
    return {};
  }

 private:
  std::size_t block() const { return static_cast<std::size_t>(patch_vertices(level_)); }
  // Of the n-th changed patch; those without a block of their own share the last one.
  std::span<std::int16_t> fresh(std::size_t n) const {
    return room_.heights.subspan(std::min(n, World::EditRoom::kWhole) * block(), block());
  }
  std::span<std::int16_t> border(std::size_t n) const {
    const auto count = static_cast<std::size_t>(4 * patch_cells(level_));
    return room_.heights.subspan((World::EditRoom::kWhole + 1) * block() + n * count, count);
  }
  // Calls visit(vertex of the block, number on the border).
  template <class Visit>
  void for_each_border(const Visit& visit) const {
    std::size_t number = 0;
    for (int edge = 0; edge < 4; ++edge) {
      const GridLine line = GridLine::along_edge(edge, 0, level_, false);
      for (int t = 0; t < patch_cells(level_); ++t) {
        visit(static_cast<std::size_t>((line.j0 + t * line.dj) * patch_side(level_) + line.i0 + t * line.di),
              number++);
      }
    }
  }

  bool reaches(const LatticeBox& box) const {
    glm::dvec3 away(0.0);  // from the brush's place to the box
    for (int axis = 0; axis < 3; ++axis) {
      const double low = box.min[axis] / kSteps, high = box.max[axis] / kSteps;
      if (!(low <= box_.high[axis] && high >= box_.low[axis])) return false;
      away[axis] = std::clamp(edit_.place[axis], low, high) - edit_.place[axis];
    }
    if (edit_.shape == BrushShape::cylinder) away.y = 0;
    if (edit_.shape != BrushShape::cylinder && edit_.shape != BrushShape::sphere) return true;
    return glm::dot(away, away) <= edit_.radius * edit_.radius;
  }

  // Patches that a brush may reach, ascending.
  template <class Visit>
  void for_each_reached(const Visit& visit) const {
    const auto reaches_box = [this](const LatticeBox& box) { return reaches(box); };
    ReachedPatches{*all_.tree, all_.surface, all_.bounds, reaches_box, visit}.run();
  }

  std::uint64_t count() const {
    std::uint64_t reached = 0;
    for_each_reached([&](PatchId) { ++reached; });
    return reached;
  }

  // Vertices of a row that the brush reaches; there is room for a last pair, and for displace_line().
  struct Row {
    static constexpr std::size_t kRoom = (1 << kMaxLevel) + 4;

    std::size_t count = 0;
    int i[kRoom];
    double place[3][kRoom];  // voxels
    double weight[kRoom];
    double move[kRoom];  // what is added where the brush has its whole strength, lattice steps

    void take_place(std::size_t n, Double2 (&out)[3]) const {
      for (int axis = 0; axis < 3; ++axis) out[axis] = simd::load(place[axis] + n);
    }
    // The last one again where its pair needs another.
    void fill_up() {
      if (count == 0) return;
      i[count] = i[count - 1];
      for (double(&axis)[kRoom] : place) axis[count] = axis[count - 1];
    }
  };

  // A patch's heights after the edit. False: they are as before.
  bool make(PatchId patch, std::span<std::int16_t> out, PatchExtent& extent) const {
    const int side = patch_side(level_);
    const PatchShape shape = PatchShape::make(all_.surface, heights_, level_, patch);
    const glm::dvec3 origin(patch_origin(all_.surface.volume_of(patch)));
    Row row;
    extent = {};
    for (int j = 0; j < side; ++j) {
      std::int16_t* const heights = out.data() + j * side;
      if (shape.heights == nullptr) {
        std::fill_n(heights, side, std::int16_t{0});
      } else {
        std::copy_n(shape.heights + j * side, side, heights);
      }
      reach(shape, origin, j, row);
      if (row.count == 0) continue;
      find_moves(shape, patch, origin, j, row);
      for (std::size_t n = 0; n < row.count; ++n) {
        const std::int32_t before = heights[row.i[n]];
        const std::int32_t after = rounded(before + row.weight[n] * row.move[n]);
        heights[row.i[n]] = static_cast<std::int16_t>(after);
        if (after != before) extent.add(level_, row.i[n], j);
      }
    }
    return extent.rows.any();
  }

  // Vertices of row j with a weight.
  void reach(const PatchShape& shape, const glm::dvec3& origin, int j, Row& row) const {
    const int side = patch_side(level_);
    float line[3][Row::kRoom];
    displace_line(shape, {0, j, 1, 0}, glm::vec3(0), line[0], line[1], line[2]);
    row.count = 0;
    for (int i = 0; i < side; ++i) {
      int outside = 0;  // without branches
      row.i[row.count] = i;
      for (int axis = 0; axis < 3; ++axis) {
        const double at = (origin[axis] + double{line[axis][i]}) / kSteps;
        row.place[axis][row.count] = at;
        outside |= static_cast<int>(at < box_.low[axis]) | static_cast<int>(at > box_.high[axis]);
      }
      row.count += static_cast<std::size_t>(1 - outside);
    }
    row.fill_up();
    Double2 place[3];
    for (std::size_t n = 0; n < row.count; n += 2) {
      row.take_place(n, place);
      simd::store(row.weight + n, brush_weights(edit_, place));
    }
    std::size_t kept = 0;
    for (std::size_t n = 0; n < row.count; ++n) {
      row.i[kept] = row.i[n];
      row.weight[kept] = row.weight[n];
      for (double(&axis)[Row::kRoom] : row.place) axis[kept] = axis[n];
      kept += row.weight[n] > 0 ? 1 : 0;
    }
    row.count = kept;
    row.fill_up();
  }

  static std::int32_t rounded(double height) {
    const double up = std::clamp(height + 0.5, double{-kMaxHeight}, kMaxHeight + 0.5);
    const auto whole = static_cast<std::int32_t>(up);
    return whole - (up < whole ? 1 : 0);
  }

  void find_moves(const PatchShape& shape, PatchId patch, const glm::dvec3& origin, int j, Row& row) const {
    const double strength = edit_.strength * kSteps;
    Double2 place[3];
    switch (edit_.tool) {
      case EditTool::extrude:
        std::fill_n(row.move, row.count, strength);
        lift(shape, j, row);
        return;
      case EditTool::noise:
        for (std::size_t n = 0; n < row.count; n += 2) {
          row.take_place(n, place);
          // Noise is one over all parts and the ground.
          for (int axis = 0; axis < 3; ++axis) place[axis] = (place[axis] + corner_[axis]) / edit_.wave;
          simd::store(row.move + n, strength * simplex_noise(place, edit_.seed));
        }
        lift(shape, j, row);
        return;
      case EditTool::smooth:
        for (std::size_t n = 0; n < row.count; ++n)
          row.move[n] = edit_.amount * (around_.mean(patch, row.i[n], j) - shape.height(row.i[n], j));
        return;
      default:
        find_moves_onto_plane(shape, origin, j, row);
    }
  }

  // Where a vertex moves along a direction by what that has upwards, a slope across it rises by one.
  void lift(const PatchShape& shape, int j, Row& row) const {
    if (!all_.mirrors) return;
    for (std::size_t n = 0; n < row.count; ++n) {
      double away = kSideVoxels;
      for (const int axis : {0, 2})
        away = std::min({away, row.place[axis][n] - 0.5, all_.extent[axis] - 0.5 - row.place[axis][n]});
      if (away >= kSideVoxels) continue;
      const double inside = std::max(away, 0.0) / kSideVoxels;
      row.move[n] *= inside + (1 - inside) * std::max(base_point(shape, row.i[n], j).direction.y, 0.0);
    }
  }

  void find_moves_onto_plane(const PatchShape& shape, const glm::dvec3& origin, int j, Row& row) const {
    const LineCurve curve = line_curve(shape, {0, j, 1, 0});
    const glm::dvec3 from = edit_.place - origin / kSteps;
    for (std::size_t n = 0; n < row.count; n += 2) {
      const int i0 = row.i[n], i1 = row.i[n + 1];
      const BasePoints2 base = base_points(shape, curve, i0, i1);
      const Double2 height{shape.height(i0, j) / kSteps, shape.height(i1, j) / kSteps};
      Double2 below = simd::splat(0.0), across = simd::splat(0.0);
      for (int axis = 0; axis < 3; ++axis) {
        below += (from[axis] - base.position[axis] - base.direction[axis] * height) * up_[axis];
        across += base.direction[axis] * up_[axis];
      }
      const Double2 least = simd::splat(kLeastAcross * kLeastAcross);
      simd::store(row.move + n, edit_.amount * (below * kSteps * across / simd::max(across * across, least)));
    }
  }

  // Once a patch and part. A part is taken back as one, so a long stroke has several.
  void keep(std::span<const PatchId> changed, UndoLog& log) const {
    constexpr std::uint32_t kMostCells = 64;
    if (log.open_part() != CellKind::patch_heights || log.part_cells() >= kMostCells) log.begin_part();
    for (const PatchId patch : changed) {
      const auto part = [&] { return static_cast<std::uint32_t>(log.part_number()); };
      std::uint32_t& kept = room_.kept[all_.first + patch];
      if (log.open_part() == CellKind::patch_heights && kept == part()) continue;
      keep_heights(all_, patch, key_of(all_.surface, patch, part_).bits(), log);
      kept = part();
    }
  }

  World::Editable all_;
  std::uint32_t part_;
  glm::dvec3 corner_;
  const World::EditRoom& room_;
  Edit edit_;
  int level_;
  Heights heights_;
  HeightsAround around_;
  BrushBox box_;
  glm::dvec3 up_;
};

}  // namespace

void put_heights(const World::Editable& all, PatchId patch, std::span<const std::int16_t> heights) {
  std::ranges::copy(heights, all.heights->block(all.first + patch).begin());
  const bool flat = std::ranges::all_of(heights, [](std::int16_t height) { return height == 0; });
  all.patches[patch].height_block = flat ? kNoHeights : all.first + patch;
}

PatchId ExchangeHeights::find(UndoCell cell, std::size_t& part) const {
  const PatchKey key = PatchKey::from_bits(cell.key);
  part = key.region();
  const PatchId patch = world_.edit(part).slots->table().find(key.in_part());
  KARST_ASSERT(patch != PatchTable::kNone);
  return patch;
}

ExchangeHeights::ExchangeHeights(World& world, UndoPart part)
    : world_(world), part_(part), at_(part.begin()) {
  for (const UndoCell cell : part_) {
    std::size_t of = 0;
    const PatchId patch = find(cell, of);
    const World::Editable all = world_.edit(of);
    // A block of the file may be all zeros: whether there is one is exchanged, too.
    PatchCell before;
    std::memcpy(&before, cell.bytes.data(), sizeof before);
    const PatchCell after{all.patches[patch].height_block != kNoHeights};
    const std::span<std::int16_t> now = current_heights(all, patch);
    const auto bytes = cell.bytes.subspan(sizeof before);
    KARST_ASSERT(bytes.size() == now.size_bytes());
    std::ranges::swap_ranges(bytes, std::as_writable_bytes(now));
    all.patches[patch].height_block = before.has_heights ? all.first + patch : kNoHeights;
    std::memcpy(cell.bytes.data(), &after, sizeof after);
  }
}

bool ExchangeHeights::next(EditChange& change) {
  change = {};
  if (at_ == part_.end()) return false;
  static_cast<void>(find(*at_, change.part));
  const World::Editable all = world_.edit(change.part);
  const std::span<PatchId> changed = all.room->changed;
  std::size_t count = 0;
  for (UndoPart::Iterator end = at_; end != part_.end() && count < changed.size(); ++end) {
    const UndoCell cell = *end;
    std::size_t of = 0;
    const PatchId patch = find(cell, of);
    if (of != change.part) break;
    all.room->extents[count] = extent_of(cell.bytes.subspan(sizeof(PatchCell)),
                                         all.heights->block(all.first + patch), world_.info().level);
    changed[count++] = patch;
  }
  // One alone finds room: the edit did.
  while (count > 1 &&
         !find_touched(all.surface, changed.first(count), all.room->touched, change.touched).ok())
    count /= 2;
  for (std::size_t n = 0; n < count; ++n) ++at_;
  change.changed = true;
  FollowChange follow(all, world_.info().level, change);
  change.box = follow.box_before(changed[0]);
  follow.run(changed.first(count), {}, all.room->extents.first(count), false);
  return true;
}

Status check_heights_edit(const Edit& edit, const World& world) {
  if (const Status status = check_edit(edit, world); !status.ok()) return status;
  if (edit.shape == BrushShape::voxel) return refuse("heights have no voxels", "shape");
  const glm::dvec3& half = edit.half;
  if (edit.shape == BrushShape::box && !(half.x > 0 && half.y > 0 && half.z > 0))
    return refuse("not a positive length", "half_m");
  if (edit.shape != BrushShape::box && !(edit.radius > 0)) return refuse("not a positive length", "radius_m");
  if (edit.tool == EditTool::flatten && !(glm::dot(edit.up, edit.up) > 0x1p-40))
    return refuse("not a direction", "up");
  return {};
}

Status try_heights(World& world, std::size_t part, const Edit& edit, std::size_t& patches) {
  patches = 0;
  if (const Status status = check_heights_edit(edit, world); !status.ok()) return status;
  return HeightsEdit(world, part, from_part(edit, world.parts()[part])).plan(patches);
}

Status edit_heights(World& world, std::size_t part, const Edit& edit, UndoLog* log, EditChange& change) {
  change = {};
  change.part = part;
  if (const Status status = check_heights_edit(edit, world); !status.ok()) return status;
  KARST_ASSERT(edits_heights(edit.tool));
  return HeightsEdit(world, part, from_part(edit, world.parts()[part])).run(log, change);
}

}  // namespace karst::core
