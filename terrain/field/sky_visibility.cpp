// SPDX-License-Identifier: MIT
#include "terrain/field/sky_visibility.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

#include "terrain/base/check.h"

namespace karst::core {
namespace {

using Word = std::uint64_t;
constexpr Word kAll = ~Word{0};

// Rings of directions at evenly spaced heights, sin = 0.05, 0.15 .. 0.95: rings of equal solid angle.
// Cells sideways a cell upwards, in 1/256: the cotangents.
constexpr int kSlopeUnit = 256;
constexpr int kRings = 10;
constexpr int kCotangents[kRings] = {5114, 1687, 992, 685, 508, 389, 299, 226, 159, 84};
// Around each, turned by half a step from ring to ring: cosines of 0, 7.5 .. 90 degrees, in 1/1024.
constexpr int kTurnUnit = 1024;
constexpr int kTurns = 24;
constexpr int kCosines[2 * kTurns / 4 + 1] = {1024, 1015, 989, 946, 887, 812, 724,
                                              623,  512,  392, 265, 134, 0};
static_assert(kRings * kTurns == SkyVisibility::kDirections);

// Of n half steps, any n.
constexpr int cosine(int n) {
  n = (n % (2 * kTurns) + 2 * kTurns) % (2 * kTurns);
  if (n > kTurns) n = 2 * kTurns - n;
  return n <= kTurns / 2 ? kCosines[n] : -kCosines[kTurns - n];
}

// Planes of counters: 2^8 - 1 is more than there are directions. The 8 words of 64 cells turn into their 64
// bytes in place.
constexpr std::size_t kPlanes = 8;

struct Size {
  std::size_t row, layer, all;  // words of bits
};

Size size_of(const SkyGrid& grid) {
  const std::size_t row = (static_cast<std::size_t>(grid.cells.x) + 63) / 64;
  const std::size_t layer = row * static_cast<std::size_t>(grid.cells.z);
  return {row, layer, layer * static_cast<std::size_t>(grid.cells.y)};
}

std::size_t words_of(const SkyGrid& grid) {
  const Size size = size_of(grid);
  return size.all * (kPlanes + 1) + size.layer;
}

SkyGrid grid_of(glm::ivec3 extent, int cell_log2) {
  glm::ivec3 cells = (extent + ((1 << cell_log2) - 1)) >> cell_log2;
  ++cells.y;
  return {cells, cell_log2};
}

// Sideways along a line, in whole cells at its n-th of many steps, `per_layer` of them a layer. Mirrored
// lines have mirrored places.
int place_on(int slope, int n, int per_layer) {
  const int unit = kSlopeUnit * per_layer;
  const int places = (2 * std::abs(slope) * n + unit) / (2 * unit);
  return slope < 0 ? -places : places;
}

}  // namespace

// The parts of the storage.
struct SkyVisibility::Rows {
  SkyGrid grid;
  Size size;
  Word* counts;  // [y][z][x / 64][plane]
  Word* open;    // [y][z][x / 64], bits x; those beyond the grid are open
  Word* layer;   // [z][x / 64]: rays from the cells of a layer that reach the sky

  Rows(const SkyGrid& of, std::span<Word> storage)
      : grid(of),
        size(size_of(of)),
        counts(storage.data()),
        open(counts + size.all * kPlanes),
        layer(open + size.all) {}

  bool is_open(glm::ivec3 cell) const {
    const auto row = static_cast<std::size_t>(cell.y * grid.cells.z + cell.z);
    const auto x = static_cast<std::size_t>(cell.x);
    return (open[row * size.row + x / 64] >> (x % 64) & 1) != 0;
  }

  void fill(glm::ivec3 low, glm::ivec3 high) const;
  std::int64_t fill_nodes(const Octree& octree, Octree::Node node, glm::ivec3 origin, int level) const;
  void move_x(const Word* through, int step) const;
  void move_z(const Word* through, int step) const;
  void begin(const Octree& octree) const;
  void follow(int direction) const;
  void follow(int slope_x, int slope_z) const;
  void count(Word* into) const;
  void write_shares(int y) const;
  void spread(int y, std::uint8_t* cells) const;
};

// Cells low..high, both included.
void SkyVisibility::Rows::fill(glm::ivec3 low, glm::ivec3 high) const {
  high = glm::min(high, grid.cells - 1);
  for (int y = low.y; y <= high.y; ++y) {
    for (int z = low.z; z <= high.z; ++z) {
      Word* const row = open + static_cast<std::size_t>(y * grid.cells.z + z) * size.row;
      for (int x = low.x; x <= high.x; ++x) row[x / 64] &= ~(Word{1} << (x % 64));
    }
  }
}

// Returns how many voxels are filled, where that decides on a cell. level: log2 of the node's side.
std::int64_t SkyVisibility::Rows::fill_nodes(const Octree& octree, Octree::Node node, glm::ivec3 origin,
                                             int level) const {
  const int cell = grid.cell_log2;
  std::int64_t filled = 0;
  if (Octree::is_leaf(node)) {
    if (!Octree::is_filled(node)) return 0;
    filled = std::int64_t{1} << (3 * level);
    if (level > cell) fill(origin >> cell, (origin + (1 << level) - 1) >> cell);
  } else {
    const int half = 1 << (level - 1);
    for (int o = 0; o < 8; ++o) {
      const glm::ivec3 corner(o & 1, o >> 1 & 1, o >> 2 & 1);
      filled += fill_nodes(octree, octree.child(node, o), origin + half * corner, level - 1);
    }
  }
  if (level == cell && 2 * filled >= std::int64_t{1} << (3 * cell)) fill(origin >> cell, origin >> cell);
  return filled;
}

// Rays from each cell: through it, and from the next cell as known. Outside the sides is sky.
void SkyVisibility::Rows::move_x(const Word* through, int step) const {
  for (std::size_t first = 0; first < size.layer; first += size.row) {
    Word* const row = layer + first;
    const Word* const by = through + first;
    if (step > 0) {
      for (std::size_t w = 0; w < size.row; ++w) {
        const Word next = w + 1 < size.row ? row[w + 1] : kAll;
        row[w] = (row[w] >> 1 | next << 63) & by[w];
      }
    } else {
      for (std::size_t w = size.row; w-- > 0;) {
        const Word next = w > 0 ? row[w - 1] : kAll;
        row[w] = (row[w] << 1 | next >> 63) & by[w];
      }
    }
  }
}

void SkyVisibility::Rows::move_z(const Word* through, int step) const {
  const std::size_t rest = size.layer - size.row;
  if (step > 0) {
    for (std::size_t w = 0; w < rest; ++w) layer[w] = layer[w + size.row] & through[w];
    for (std::size_t w = rest; w < size.layer; ++w) layer[w] = through[w];
  } else {
    for (std::size_t w = size.layer; w-- > size.row;) layer[w] = layer[w - size.row] & through[w];
    for (std::size_t w = 0; w < size.row; ++w) layer[w] = through[w];
  }
}

void SkyVisibility::Rows::count(Word* into) const {
  for (std::size_t w = 0; w < size.layer; ++w, into += kPlanes) {
    Word carry = layer[w];
    for (std::size_t plane = 0; carry != 0; ++plane) {
      const Word both = into[plane] & carry;
      into[plane] ^= carry;
      carry = both;
    }
  }
}

// Adds the rays of a direction. From a layer's middle to the next one's there are `steps` steps; in each a
// ray moves by a cell at most on each axis, upwards in the middle.
void SkyVisibility::Rows::follow(int slope_x, int slope_z) const {
  const int most = std::max(std::abs(slope_x), std::abs(slope_z));
  const int steps = 2 * ((most + kSlopeUnit - 1) / kSlopeUnit);
  std::fill(layer, layer + size.layer, kAll);
  for (int y = grid.cells.y - 1; y >= 0; --y) {
    const Word* const here = open + static_cast<std::size_t>(y) * size.layer;
    // The topmost layer has nothing above.
    const Word* const above = y + 1 < grid.cells.y ? here + size.layer : here;
    for (int n = (y + 1) * steps; n-- > y * steps;) {
      const bool up = n >= y * steps + steps / 2;
      const Word* const through = up ? above : here;
      const int x = place_on(slope_x, n + 1, steps) - place_on(slope_x, n, steps);
      const int z = place_on(slope_z, n + 1, steps) - place_on(slope_z, n, steps);
      if (x != 0) move_x(through, x);
      if (z != 0) move_z(through, z);
      if (n == y * steps + steps / 2) {
        for (std::size_t w = 0; w < size.layer; ++w) layer[w] &= here[w];
      }
    }
    count(counts + static_cast<std::size_t>(y) * size.layer * kPlanes);
  }
}

void SkyVisibility::Rows::begin(const Octree& octree) const {
  std::fill_n(counts, size.all * kPlanes, Word{0});
  std::fill_n(open, size.all, kAll);
  fill_nodes(octree, octree.root(), glm::ivec3(0), octree.depth());
}

void SkyVisibility::Rows::follow(int direction) const {
  const int ring = direction / kTurns;
  const int angle = 2 * (direction % kTurns) + ring % 2;
  const int cot = kCotangents[ring];
  follow(cot * cosine(angle) / kTurnUnit, cot * cosine(angle - kTurns / 2) / kTurnUnit);
}

// Counters of a layer to bytes, in place: a row's bytes end before the next row's counters begin, so that
// layers follow each other from the lowest on.
void SkyVisibility::Rows::write_shares(int y) const {
  auto* const bytes = reinterpret_cast<std::uint8_t*>(counts);
  const std::size_t first = static_cast<std::size_t>(y) * size.layer;
  for (std::size_t w = first; w < first + size.layer; ++w) {
    Word planes[kPlanes];
    std::copy_n(counts + w * kPlanes, kPlanes, planes);
    const std::size_t x = w % size.row * 64;
    std::uint8_t* const out = bytes + w / size.row * grid.row_bytes() + x;
    const std::size_t cells = std::min<std::size_t>(grid.row_bytes() - x, 64);
    for (std::size_t k = 0; k < cells; ++k) {
      unsigned rays = 0;
      for (std::size_t p = 0; p < kPlanes; ++p) rays |= static_cast<unsigned>(planes[p] >> k & 1) << p;
      out[k] = static_cast<std::uint8_t>((rays * 255 + kDirections / 2) / kDirections);
    }
  }
}

// Reads open cells and writes filled ones.
void SkyVisibility::Rows::spread(int y, std::uint8_t* cells) const {
  glm::ivec3 c(0, y, 0);
  for (c.z = 0; c.z < grid.cells.z; ++c.z) {
    for (c.x = 0; c.x < grid.cells.x; ++c.x) {
      if (is_open(c)) continue;
      const glm::ivec3 low = glm::max(c - 1, 0);
      const glm::ivec3 high = glm::min(c + 1, grid.cells - 1);
      unsigned sum = 0;
      unsigned found = 0;
      glm::ivec3 n;
      for (n.y = low.y; n.y <= high.y; ++n.y) {
        for (n.z = low.z; n.z <= high.z; ++n.z) {
          for (n.x = low.x; n.x <= high.x; ++n.x) {
            if (!is_open(n)) continue;
            sum += cells[grid.place(n)];
            ++found;
          }
        }
      }
      if (found > 0) cells[grid.place(c)] = static_cast<std::uint8_t>((sum + found / 2) / found);
    }
  }
}

SkyGrid SkyVisibility::grid_for(glm::ivec3 extent, std::size_t words, int least_log2) {
  for (int k = least_log2; k <= kMaxDepth; ++k) {
    const SkyGrid grid = grid_of(extent, k);
    if (std::max({grid.cells.x, grid.cells.y, grid.cells.z}) > kMostSide) continue;
    if (grid.bytes() <= kMostBytes && words_of(grid) <= words) return grid;
  }
  return {};
}

std::size_t SkyVisibility::word_count(glm::ivec3 extent) {
  return words_of(grid_for(extent, SIZE_MAX));
}

void SkyVisibility::open_sides(std::uint8_t* cells) const {
  constexpr int kFade = 4;  // cells
  glm::ivec3 c;
  for (c.y = 0; c.y < grid_.cells.y; ++c.y) {
    for (c.z = 0; c.z < grid_.cells.z; ++c.z) {
      for (c.x = 0; c.x < grid_.cells.x; ++c.x) {
        const int inside = std::min({c.x, c.z, grid_.cells.x - 1 - c.x, grid_.cells.z - 1 - c.z});
        if (inside >= kFade) continue;
        std::uint8_t& cell = cells[grid_.place(c)];
        cell = static_cast<std::uint8_t>(255 - (255 - cell) * inside / kFade);
      }
    }
  }
}

bool SkyVisibility::has_cells() const {
  return grid_.bytes() <= storage_.size_bytes() && words_of(grid_) <= storage_.size();
}

void SkyVisibility::build(const Octree& octree, glm::ivec3 extent, bool opens_sides) {
  grid_ = grid_for(extent, storage_.size(), least_log2_);
  opens_sides_ = opens_sides;
  behind_ = false;
  step_ = 0;
  if (!has_cells()) return;
  const Rows rows(grid_, storage_);
  rows.begin(octree);
  for (int n = 0; n < kDirections; ++n) rows.follow(n);
  for (int y = 0; y < grid_.cells.y; ++y) rows.write_shares(y);
  auto* const cells = reinterpret_cast<std::uint8_t*>(storage_.data());
  for (int y = 0; y < grid_.cells.y; ++y) rows.spread(y, cells);
  if (opens_sides_) open_sides(cells);
}

bool SkyVisibility::step(const Octree& octree, std::span<std::uint64_t> room) {
  if (!has_cells()) {
    behind_ = false;
    return false;
  }
  const Rows rows(grid_, room);
  const Rows old(grid_, storage_);
  const int layers = grid_.cells.y;
  auto* const cells = reinterpret_cast<std::uint8_t*>(room.data());
  const int n = step_++;
  if (n == 0) {
    behind_ = false;
    rows.begin(octree);
    if (std::equal(rows.open, rows.open + rows.size.all, old.open)) step_ = 0;
  } else if (n <= kDirections) {
    rows.follow(n - 1);
  } else if (n <= kDirections + layers) {
    rows.write_shares(n - kDirections - 1);
  } else if (n <= kDirections + 2 * layers) {
    rows.spread(n - kDirections - layers - 1, cells);
  } else {
    step_ = 0;
    if (opens_sides_) open_sides(cells);
    std::copy(rows.open, rows.open + rows.size.all, old.open);
    auto* const held = reinterpret_cast<std::uint8_t*>(storage_.data());
    if (std::equal(cells, cells + grid_.bytes(), held)) return false;
    std::copy(cells, cells + grid_.bytes(), held);
    return true;
  }
  return false;
}

std::span<const std::uint8_t> SkyVisibility::cells() const {
  static constexpr std::uint8_t kOpen[4] = {255, 255, 255, 255};
  if (grid_ == SkyGrid()) return kOpen;
  return {reinterpret_cast<const std::uint8_t*>(storage_.data()), grid_.bytes()};
}

std::uint8_t SkyVisibility::least_in(glm::vec3 low, glm::vec3 high) const {
  const float scale = 1.0f / grid_.cell_voxels();
  const glm::ivec3 last = grid_.cells - 1;
  const glm::ivec3 from = glm::clamp(glm::ivec3(glm::floor(low * scale - 0.5f)), glm::ivec3(0), last);
  const glm::ivec3 to = glm::clamp(glm::ivec3(glm::floor(high * scale - 0.5f)) + 1, glm::ivec3(0), last);
  std::uint8_t least = 255;
  glm::ivec3 c;
  for (c.y = from.y; c.y <= to.y; ++c.y) {
    for (c.z = from.z; c.z <= to.z; ++c.z) {
      for (c.x = from.x; c.x <= to.x; ++c.x) least = std::min(least, at(c));
    }
  }
  return least;
}

}  // namespace karst::core
