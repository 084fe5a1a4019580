// SPDX-License-Identifier: MIT
#include "terrain/regions/belts.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "terrain/base/check.h"
#include "terrain/draw/wall_indices.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {
namespace {

// Along a side, in units that divide half voxels at every level.
constexpr std::int64_t kAlong = std::int64_t{1} << (kMaxLevel + 8);

// Grid place of vertex t along edge e at a level.
struct GridPlace {
  int i, j;
};
GridPlace on_edge(int edge, int cells, int t) {
  switch (edge) {
    case 0:
      return {t, 0};
    case 1:
      return {cells, t};
    case 2:
      return {cells - t, cells};
    default:
      return {0, cells - t};
  }
}

// A vertex of a rim: where it lies in the buffer, and along the side.
struct RimVertex {
  std::uint32_t index = 0;
  std::int64_t along = 0;
};

// The vertices of rim edges first .. end - 1 one by one, without those of patches that are not there.
class RimWalk {
 public:
  RimWalk(const BuildBelts& job, std::uint32_t first, std::uint32_t end) : job_(job), at_(first), end_(end) {}

  bool next(RimVertex& vertex) {
    for (;; ++at_, t_ = 1) {
      if (at_ == end_) return false;
      const RegionRim::Edge& edge = job_.rim->edges()[at_];
      const PatchId id = edge.edge.patch();
      const int level = std::min(job_.levels[id], job_.resident[id]);
      // The first vertex is the last one of the edge before, if that was there.
      if (level == 0) {
        started_ = false;
        continue;
      }
      const int cells = 1 << level;
      if (!started_) t_ = 0;
      if (t_ > cells) continue;
      const GridPlace place = on_edge(edge.edge.edge(), cells, t_);
      if (!find(id, static_cast<std::uint32_t>(vertex_order(level, place.i, place.j)), vertex.index)) {
        started_ = false;
        continue;
      }
      vertex.along = kAlong * edge.from + (kAlong >> level) * t_ * (edge.to - edge.from);
      started_ = true;
      ++t_;
      return true;
    }
  }

 private:
  // Where vertex v of a patch's slot lies.
  bool find(PatchId id, std::uint32_t v, std::uint32_t& index) const {
    std::uint32_t page = id < job_.pages.first_page.size() ? job_.pages.first_page[id] : kNoPage;
    for (std::uint32_t n = v / kPageVertices; n > 0 && page < job_.pages.next_page.size(); --n)
      page = job_.pages.next_page[page];
    if (page >= job_.pages.next_page.size()) return false;
    index = page * kPageVertices + v % kPageVertices;
    return true;
  }

  const BuildBelts& job_;
  std::uint32_t at_, end_;
  int t_ = 0;
  bool started_ = false;
};

// The points first .. end of an isosurface's rim, the last of which is one of the next side's where the side
// ends there.
class PointWalk {
 public:
  PointWalk(const BuildBelts& job, int side, std::uint32_t first, std::uint32_t end, std::int64_t end_along)
      : job_(job), side_begin_(BlockRim::kSide * side), at_(first), end_(end), end_along_(end_along) {}

  bool next(RimVertex& vertex) {
    if (at_ > end_) return false;
    const std::span<const BlockRim::Point> points = job_.blocks->points();
    const BlockRim::Point& point = points[at_ == points.size() ? 0 : at_];
    vertex.index = job_.first_mesh_page * kPageVertices + point.vertex;
    vertex.along = at_ == end_ ? end_along_ : (point.along - side_begin_) * kAlongAStep;
    ++at_;
    return true;
  }

 private:
  static constexpr std::int64_t kAlongAStep = kAlong / (kStepsPerVoxel / 2);

  const BuildBelts& job_;
  std::int64_t side_begin_;
  std::uint32_t at_, end_;
  std::int64_t end_along_;
};

}  // namespace

struct BuildBelts::Piece {
  std::uint32_t first_edge = 0, end_edge = 0;  // of the rim
  std::array<RimVertex, kNodeSide> ground;     // in the rim's order
  int count = 0;
};

// From the piece's beginning on, one vertex further on the side that is behind.
template <class Walk>
std::size_t BuildBelts::write(Walk walk, const Piece& piece, std::span<std::uint32_t> to) const {
  RimVertex own, own_next;
  if (!walk.next(own)) return 0;
  std::size_t used = 0;
  const auto triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    for (const std::uint32_t v : {a, b, c}) to[used++] = v;
  };
  bool more = walk.next(own_next);
  int k = 0;
  while (more || k + 1 < piece.count) {
    if (used + 3 > to.size()) return 0;
    const std::uint32_t ground = piece.ground[static_cast<std::size_t>(k)].index;
    const bool by_rim = more && (k + 1 == piece.count ||
                                 own_next.along <= piece.ground[static_cast<std::size_t>(k) + 1].along);
    if (by_rim) {
      triangle(own_next.index, own.index, ground);
      own = own_next;
      more = walk.next(own_next);
    } else {
      ++k;
      triangle(ground, piece.ground[static_cast<std::size_t>(k)].index, own.index);
    }
  }
  return used;
}

std::size_t BuildBelts::run() const {
  KARST_ASSERT(info != nullptr && view != nullptr && levels.size() == resident.size());
  KARST_ASSERT((rim != nullptr) != (blocks != nullptr));
  if (blocks == nullptr) return run_along(*rim);
  const std::size_t used = run_along(*blocks);
  return used + fill_loops(out.subspan(used));
}

// From the first point of each.
std::size_t BuildBelts::fill_loops(std::span<std::uint32_t> to) const {
  std::size_t used = 0;
  for (std::size_t n = 0; n < blocks->loops(); ++n) {
    const std::span<const BlockRim::Point> points = blocks->loop(n);
    if (points.size() < 3 || used + 3 * (points.size() - 2) > to.size()) continue;
    for (std::size_t k = 1; k + 1 < points.size(); ++k) {
      for (const std::size_t v : {std::size_t{0}, k + 1, k})
        to[used++] = first_mesh_page * kPageVertices + points[v].vertex;
    }
  }
  return used;
}

template <class Rim>
std::size_t BuildBelts::run_along(const Rim& line) const {
  std::size_t used = 0;
  if (line.count() == 0 || line.columns() == 0) return 0;
  const GroundRegion& whole = info->regions()[region];
  const NodeRect& rect = whole.nodes;
  for (std::size_t n = 0; n < view->items().size(); ++n) {
    const DrawItem& item = view->items()[n];
    const NodeKey key = view->node_of(n).key;
    if (((std::uint32_t{view->node_of(n).touches} >> region) & 1u) == 0 || !borders(whole, key)) continue;
    const std::int64_t low[2] = {std::int64_t{key.x} << key.size, std::int64_t{key.z} << key.size};
    const std::int64_t side = std::int64_t{1} << key.size;
    for (int s = 0; s < 4; ++s) {
      // Across side s, and along it.
      const int across = s % 2 == 0 ? 0 : 1, along = 1 - across;
      const bool is_beside =
          s == 0 || s == 3 ? low[across] + side == rect.low[across] : low[across] == rect.high[across];
      if (!is_beside) continue;
      const auto edge = static_cast<std::size_t>((s + 2) % 4);  // of the node
      const std::uint32_t page = first_node_page + item.patch;
      const int step = (item.lower_edges >> edge & 1u) != 0 ? 2 : 1;
      const int parts = key.size > 0 ? 2 : 1;
      const std::int64_t span = side / parts;
      for (int part = 0; part < parts; ++part) {
        // Columns of the part: the walk along sides 2 and 3 goes down.
        const std::int64_t first = s < 2 ? low[along] + part * span - rect.low[along]
                                         : rect.high[along] - low[along] - side + part * span;
        const auto on_side = static_cast<std::int64_t>(line.first_column(s + 1) - line.first_column(s));
        if (first < 0 || first + span > on_side) continue;
        const std::uint32_t column = line.first_column(s) + static_cast<std::uint32_t>(first);
        const std::uint32_t end = column + static_cast<std::uint32_t>(span);
        Piece piece;
        piece.first_edge = line.mark(column);
        piece.end_edge = end == line.columns() ? line.count() : line.mark(end);
        const std::int64_t unit = kAlong * (2 << info->lattice_size) * span;
        const int quads = kNodeQuads / parts;
        for (int q = 0; q <= quads; q += step) {
          // The node's own walk goes the other way.
          const int v = kNodeQuads - part * quads - q;
          piece.ground[static_cast<std::size_t>(piece.count++)] = {
              page * kPageVertices + kNodeEdges[edge][static_cast<std::size_t>(v)],
              kAlong * (2 << info->lattice_size) * first + unit * q / quads};
        }
        if constexpr (std::is_same_v<Rim, BlockRim>) {
          const std::int64_t end_along = piece.ground[static_cast<std::size_t>(piece.count) - 1].along;
          used += write(PointWalk(*this, s, piece.first_edge, piece.end_edge, end_along), piece,
                        out.subspan(used));
        } else {
          used += write(RimWalk(*this, piece.first_edge, piece.end_edge), piece, out.subspan(used));
        }
      }
    }
  }
  return used;
}

}  // namespace karst::core
