// SPDX-License-Identifier: MIT
#include "terrain/blocks/block_rim.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace karst::core {
namespace {

// Edges of one block in one side, at most: four a face of a cell, of two transition cells one more each.
constexpr std::size_t kMostEdges = 2048;

struct Edge {
  std::uint16_t from = 0, to = 0;
};

// Across the side, along it, and whether the block's low end lies in it. Sides: west, south, east, north.
struct Side {
  int across, along;
  bool low;
};
constexpr Side kSides[4] = {{0, 2, true}, {2, 0, false}, {0, 2, false}, {2, 0, true}};

}  // namespace

unsigned sides_of(const FieldInfo& info, BlockKey block) {
  if (!info.in_region) return 0;
  const glm::ivec3 drawn = info.drawn_blocks();
  unsigned sides = 0;
  for (unsigned s = 0; s < 4; ++s) {
    const int at = block.place()[kSides[s].across];
    const bool ends = kSides[s].low ? at == 0 : (at + 1) << block.level == drawn[kSides[s].across];
    sides |= ends ? 1u << s : 0u;
  }
  return sides;
}

std::size_t FindRuns::run() const {
  std::size_t used = 0;
  std::array<Edge, kMostEdges> edges;
  for (unsigned s = 0; s < 4; ++s) {
    if ((sides >> s & 1u) == 0) continue;
    const Side side = kSides[s];
    const std::int16_t plane = side.low ? 0 : static_cast<std::int16_t>(kIsoCells * kIsoStepsPerCell);
    const auto lies_in = [&](std::uint16_t v) { return vertices[v].place[side.across] == plane; };
    std::size_t count = 0;
    for (std::size_t at = 0; at + 3 <= triangles.size(); at += 3) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Edge edge{triangles[at + k], triangles[at + (k + 1) % 3]};
        if (!lies_in(edge.from) || !lies_in(edge.to)) continue;
        // What two triangles have is no border.
        std::size_t back = 0;
        while (back < count && (edges[back].from != edge.to || edges[back].to != edge.from)) ++back;
        if (back < count) {
          edges[back] = edges[--count];
          continue;
        }
        if (count == kMostEdges) return 0;
        edges[count++] = edge;
      }
    }
    // From edges that none leads to; then what goes round.
    while (count > 0) {
      std::size_t at = 0;
      const auto is_led_to = [&](std::uint16_t v) {
        return std::any_of(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count),
                           [&](const Edge& e) { return e.to == v; });
      };
      while (at < count && is_led_to(edges[at].from)) ++at;
      if (at == count) at = 0;
      const std::size_t header = used;
      if (used + kRunHeader + kPointValues > out.size()) return 0;
      used += kRunHeader;
      std::uint16_t points = 0;
      const auto add = [&](std::uint16_t v) {
        if (used + kPointValues > out.size()) return false;
        out[used++] = v;
        out[used++] = static_cast<std::uint16_t>(vertices[v].place[side.along]);
        out[used++] = static_cast<std::uint16_t>(vertices[v].place[1]);
        ++points;
        return true;
      };
      if (!add(edges[at].from)) return 0;
      for (;;) {
        const std::uint16_t to = edges[at].to;
        if (!add(to)) return 0;
        edges[at] = edges[--count];
        at = 0;
        while (at < count && edges[at].from != to) ++at;
        if (at == count) break;
      }
      out[header] = static_cast<std::uint16_t>(s);
      out[header + 1] = points;
    }
  }
  return used;
}

void BlockRim::sort_runs() {
  std::sort(
      storage_.runs.begin(), storage_.runs.begin() + static_cast<std::ptrdiff_t>(run_count_),
      [](const Run& a, const Run& b) { return std::tie(a.side_along, a.up) < std::tie(b.side_along, b.up); });
}

BlockRim::Run* BlockRim::find_run(std::int64_t side_along, std::int64_t up) {
  const std::span<Run> runs = storage_.runs.first(run_count_);
  auto found = std::lower_bound(
      runs.begin(), runs.end(), std::tie(side_along, up),
      [](const Run& run, const auto& key) { return std::tie(run.side_along, run.up) < key; });
  for (; found != runs.end() && found->side_along == side_along && found->up == up; ++found) {
    if (!found->used) return &*found;
  }
  return nullptr;
}

bool BlockRim::set_marks(const FieldInfo& info, std::int64_t column) {
  for (int side = 0; side < 4; ++side)
    first_[side + 1] = first_[side] + static_cast<std::uint32_t>(length(info, side) / column);
  if (first_[4] > storage_.marks.size()) return false;
  std::uint32_t next = 0;
  for (int side = 0; side < 4; ++side) {
    for (std::uint32_t c = first_[side]; c < first_[side + 1]; ++c) {
      const std::int64_t at = kSide * side + column * (c - first_[side]);
      while (next < point_count_ && storage_.points[next].along < at) ++next;
      storage_.marks[c] = next;
    }
  }
  return true;
}

}  // namespace karst::core
