// SPDX-License-Identifier: MIT
// Row r of a size needs rows 2r - 1 to 2r + 2 of the next smaller one, for what is inside of its tiles and
// for their borders; rows of all sizes advance together.
#include "bake/imagery/bake_imagery.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include "bake/base/parallel.h"
#include "terrain/base/check.h"
#include "terrain/base/checksum.h"

namespace karst::bake {
namespace {

// A texel may be so much of a level wider than an image's pixel.
constexpr double kCoarser = 0.25;
constexpr int kHalf = kImageInside / 2;
constexpr int kMostTogether = 32;  // tiles, that are warped and encoded at a time
constexpr std::size_t kTileTexelBytes = std::size_t{4} * kImageSide * kImageSide;
static_assert(std::int64_t{kMostTogether} * kImageSide * kImageSide <= kMostWindowTexels);

std::size_t texel_at(std::size_t side, std::ptrdiff_t x, std::ptrdiff_t y) {
  return 4 * (static_cast<std::size_t>(y) * side + static_cast<std::size_t>(x));
}

}  // namespace

// What a tile leaves for the next greater size: half as many texels of what is inside of its border.
struct BakeImagery::Quarter {
  TilePlace place;
  std::vector<std::byte> texels;  // kHalf x kHalf
};

struct BakeImagery::Level {
  std::map<std::int64_t, std::map<std::int64_t, Quarter>> rows;  // by z and x
  std::int64_t made = -1;                                        // the last row that is complete
  std::int64_t last = 0;                                         // row of the ground's nodes
  std::int64_t last_column = 0;
};

Error BakeImagery::open(const GroundGrid& grid, const GroundInfo& ground, Report& report) {
  grid_ = grid;
  report = {};
  bool covered = false;
  sizes_.clear();
  info_ = {};
  info_.least_size = ground.top_size();
  for (const std::string& path : options_.files) {
    ImageFacts facts;
    if (Error error = describe_image(grid_, path, facts); !error.ok()) return error;
    const double size = std::floor(std::log2(facts.pixel_samples * kTexelsPerSample) + kCoarser);
    if (size < 0) {
      report.warnings.push_back(path + ": its pixels are " + std::to_string(1 / facts.pixel_samples) +
                                " a sample of the DEM; " + std::to_string(kTexelsPerSample) + " are kept");
    }
    sizes_.push_back(static_cast<int>(std::clamp<double>(size, 0, ground.top_size())));
    info_.least_size = std::min(info_.least_size, sizes_.back());
    covered = covered || (facts.is_opaque && facts.covers_all);
    report.warnings.insert(report.warnings.end(), facts.warnings.begin(), facts.warnings.end());
    report.images.push_back(std::move(facts));
  }
  info_.format = options_.format;
  if (covered && info_.format == ImageFormat::etc2_rgba) info_.format = ImageFormat::etc2_rgb;
  report.info = info_;
  report.texel_samples = std::ldexp(1.0, info_.least_size) / kTexelsPerSample;
  return {};
}

struct BakeImagery::Job {
  BakeImagery& bake;
  WorldGround& ground;
  const Write& write;
  const ReportProgress& progress;
  Report& report;
  std::map<int, Level> levels;
  bool unwritten = false;
  std::uint64_t rows_done = 0, rows_all = 0;

  struct Tile {
    NodeKey key;
    bool is_finest = false;
    std::vector<std::byte> texels, bytes;
    EncodingError error;
  };

  Error run() {
    const GroundInfo& info = ground.info;
    const int top = image_top_size(info);
    for (int size = bake.info_.least_size; size <= top; ++size) {
      Level& level = levels[size];
      const auto last = [&](int axis) {
        return (info.samples[axis] - 2) / (std::int64_t{kNodeQuads} << size);
      };
      level.last_column = last(0);
      level.last = last(1);
      rows_all += static_cast<std::uint64_t>(level.last) + 1;
    }
    if (Error error = advance(top, 0); !error.ok()) return error;
    if (unwritten) return {};
    const auto& roots = levels[top].rows[0];
    if (roots.empty()) return bake.options_.files[0] + ": no image covers any of the ground";
    ground.imagery = bake.info_;
    ground.image_root = roots.begin()->second.place;
    return {};
  }

  Error advance(int size, std::int64_t to) {
    Level& level = levels[size];
    while (level.made < std::min(to, level.last)) {
      const std::int64_t row = level.made + 1;
      if (size > bake.info_.least_size) {
        if (Error error = advance(size - 1, 2 * row + 2); !error.ok()) return error;
      }
      if (Error error = make_row(size, row); !error.ok() || unwritten) return error;
      level.made = row;
      if (progress) progress("imagery", ++rows_done, rows_all);
      if (size == bake.info_.least_size) continue;
      auto& below = levels[size - 1].rows;
      below.erase(below.begin(), below.lower_bound(2 * row + 1));
    }
    return {};
  }

  const Quarter* quarter(int size, std::int64_t x, std::int64_t z) {
    if (size < bake.info_.least_size) return nullptr;
    const auto& rows = levels[size].rows;
    const auto row = rows.find(z);
    if (row == rows.end()) return nullptr;
    const auto at = row->second.find(x);
    return at == row->second.end() ? nullptr : &at->second;
  }

  // Around a ground that closes every image lies once more on either side: samples.
  std::int64_t turn() const { return ground.info.closes() ? ground.info.basis.turn_quads : 0; }

  // Whether an image may cover some of a tile's texels, border and all.
  bool touches(std::size_t image, int size, std::int64_t x, std::int64_t z) const {
    for (int times = -1; times <= 1; ++times) {
      if ((times == 0 || turn() > 0) && touches_at(image, size, x, z, static_cast<double>(times * turn())))
        return true;
    }
    return false;
  }
  // Of a cube, the face that a tile lies on; else 0.
  int face_of(int size, std::int64_t x, std::int64_t z) const {
    const int below = ground.info.top_size() - size;
    if (!ground.info.is_cube() || below < 0) return 0;
    return std::max(0, cube_face(static_cast<int>(x >> below), static_cast<int>(z >> below)));
  }

  // The same where it lies so many samples to the east of its place.
  bool touches_at(std::size_t image, int size, std::int64_t x, std::int64_t z, double east) const {
    const double side = std::ldexp(double{kNodeQuads}, size);
    const double rim = side * kImageBorder / kImageInside;
    const ImageFacts& facts = report.images[image];
    const std::int64_t at[2] = {x, z};
    const NodeKey key{size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(z)};
    if (ground.info.is_cube() && !node_exists(ground.info, key)) return false;
    const int face = face_of(size, x, z);
    for (int axis = 0; axis < 2; ++axis) {
      const double low = static_cast<double>(at[axis]) * side - rim;
      const double moved = axis == 0 ? east : 0;
      const double first = ground.info.is_cube() ? facts.face_low[face][axis] : facts.low[axis];
      const double last = ground.info.is_cube() ? facts.face_high[face][axis] : facts.high[axis];
      if (last + moved < low || first + moved > low + side + 2 * rim) return false;
    }
    return true;
  }

  // Whether an image has this resolution there.
  bool is_wanted(int size, std::int64_t x, std::int64_t z) const {
    for (std::size_t n = 0; n < bake.sizes_.size(); ++n) {
      if (bake.sizes_[n] == size && touches(n, size, x, z)) return true;
    }
    return false;
  }

  Error make_row(int size, std::int64_t row) {
    Level& level = levels[size];
    std::vector<NodeKey> keys;
    // Where any image may be; parents lie over their children.
    const double side = std::ldexp(double{kNodeQuads}, size);
    double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
    for (const ImageFacts& facts : report.images) {
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], facts.low[axis] / side - 1);
        high[axis] = std::max(high[axis], facts.high[axis] / side + 1);
      }
    }
    if (turn() > 0) {
      low[0] = 0;
      high[0] = static_cast<double>(level.last_column);
    }
    const auto at = static_cast<double>(row);
    if (at < low[1] - 1 || at > high[1] + 1) return {};
    const auto first_column = static_cast<std::int64_t>(std::max(low[0] - 1, 0.0));
    const auto last_column =
        static_cast<std::int64_t>(std::min(high[0] + 1, static_cast<double>(level.last_column)));
    for (std::int64_t x = first_column; x <= last_column; ++x) {
      bool exists = is_wanted(size, x, row);
      for (int q = 0; q < 4 && !exists; ++q)
        exists = quarter(size - 1, 2 * x + (q & 1), 2 * row + (q >> 1)) != nullptr;
      if (exists) keys.push_back({size, static_cast<std::int32_t>(x), static_cast<std::int32_t>(row)});
    }
    for (std::size_t first = 0; first < keys.size() && !unwritten;) {
      // Side by side, so that one window has them all.
      std::size_t count = 1;
      while (first + count < keys.size() && count < kMostTogether &&
             keys[first + count].x == keys[first].x + static_cast<std::int32_t>(count) &&
             face_of(size, keys[first + count].x, row) == face_of(size, keys[first].x, row))
        ++count;
      if (Error error = make_tiles(std::span(keys).subspan(first, count)); !error.ok()) return error;
      first += count;
    }
    return {};
  }

  Error make_tiles(std::span<const NodeKey> keys) {
    std::vector<Tile> tiles(keys.size());
    for (std::size_t n = 0; n < keys.size(); ++n) {
      tiles[n].key = keys[n];
      tiles[n].texels.assign(kTileTexelBytes, std::byte{0});
    }
    if (Error error = warp(tiles); !error.ok()) return error;
    parallel_chunks(tiles.size(), 1, bake.threads_, [&](std::size_t begin, std::size_t end, int) {
      for (std::size_t n = begin; n < end; ++n) finish(tiles[n]);
    });
    for (Tile& tile : tiles) {
      if (!put(tile)) return {};
    }
    return {};
  }

  // Lays the images that are of the tiles' size or coarser, in a window that has all the tiles.
  Error warp(std::vector<Tile>& tiles) {
    const NodeKey first = tiles.front().key;
    TexelWindow window;
    window.size = first.size;
    window.face = face_of(first.size, first.x, first.z);
    window.column = std::int64_t{first.x} * kImageInside - kImageBorder;
    window.row = std::int64_t{first.z} * kImageInside - kImageBorder;
    window.width = static_cast<int>(tiles.size()) * kImageInside + 2 * kImageBorder;
    window.height = kImageSide;
    std::vector<std::byte> warped;
    for (std::size_t n = 0; n < bake.sizes_.size(); ++n) {
      if (bake.sizes_[n] < first.size) continue;
      for (int times = -1; times <= 1; ++times) {
        if (times != 0 && turn() == 0) continue;
        const auto east = static_cast<double>(times * turn());
        const bool touched = std::any_of(tiles.begin(), tiles.end(), [&](const Tile& tile) {
          return touches_at(n, tile.key.size, tile.key.x, tile.key.z, east);
        });
        if (!touched) continue;
        TexelWindow moved = window;
        moved.column -= std::llround(std::ldexp(east * kTexelsPerSample, -first.size));
        const std::string& path = bake.options_.files[n];
        Error error = read_image_window(bake.grid_, path, report.images[n], moved, warped);
        if (!error.ok()) return error;
        lay(warped, window, tiles);
      }
    }
    return {};
  }

  // A window's texels over those of its tiles.
  static void lay(const std::vector<std::byte>& warped, const TexelWindow& window, std::vector<Tile>& tiles) {
    std::vector<std::byte> own(kTileTexelBytes);
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      for (int y = 0; y < kImageSide; ++y) {
        const std::size_t from = texel_at(static_cast<std::size_t>(window.width),
                                          static_cast<std::ptrdiff_t>(t) * kImageInside, y);
        std::copy_n(warped.begin() + static_cast<std::ptrdiff_t>(from), 4 * kImageSide,
                    own.begin() + static_cast<std::ptrdiff_t>(texel_at(kImageSide, 0, y)));
      }
      lay_over(own, tiles[t].texels);
    }
  }

  // Of a cube's tile: what nothing covers beyond the edges of its face, as the nearest texel inside.
  void go_on_beyond_edges(Tile& tile) const {
    const int below = ground.info.top_size() - tile.key.size;
    if (below < 0) return;
    const int last = (1 << below) - 1;
    const bool at_edge[4] = {(tile.key.x & last) == 0, (tile.key.x & last) == last, (tile.key.z & last) == 0,
                             (tile.key.z & last) == last};
    const auto inside = [](int at, bool low, bool high) {
      if (low) at = std::max(at, kImageBorder);
      return high ? std::min(at, kImageBorder + kImageInside - 1) : at;
    };
    for (int y = 0; y < kImageSide; ++y) {
      for (int x = 0; x < kImageSide; ++x) {
        const int from_x = inside(x, at_edge[0], at_edge[1]), from_y = inside(y, at_edge[2], at_edge[3]);
        const std::size_t to = texel_at(kImageSide, x, y);
        if ((from_x == x && from_y == y) || tile.texels[to + 3] != std::byte{0}) continue;
        const std::size_t from = texel_at(kImageSide, from_x, from_y);
        std::copy_n(tile.texels.begin() + static_cast<std::ptrdiff_t>(from), 4,
                    tile.texels.begin() + static_cast<std::ptrdiff_t>(to));
      }
    }
  }

  // Takes what smaller tiles left, fills what nothing covers, and encodes.
  void finish(Tile& tile) {
    const NodeKey key = tile.key;
    tile.is_finest = true;
    for (int dz = -1; dz <= 2; ++dz) {
      for (int dx = -1; dx <= 2; ++dx) {
        const Quarter* const from =
            quarter(key.size - 1, std::int64_t{2} * key.x + dx, std::int64_t{2} * key.z + dz);
        if (from == nullptr) continue;
        tile.is_finest = tile.is_finest && (dx < 0 || dx > 1 || dz < 0 || dz > 1);
        const int left = kImageBorder + dx * kHalf;
        const int above = kImageBorder + dz * kHalf;
        for (int y = std::max(0, above); y < std::min(kImageSide, above + kHalf); ++y) {
          const int begin = std::max(0, left);
          const int end = std::min(kImageSide, left + kHalf);
          const std::size_t at = texel_at(kHalf, begin - left, y - above);
          std::copy_n(from->texels.begin() + static_cast<std::ptrdiff_t>(at), 4 * (end - begin),
                      tile.texels.begin() + static_cast<std::ptrdiff_t>(texel_at(kImageSide, begin, y)));
        }
      }
    }
    if (ground.info.is_cube()) go_on_beyond_edges(tile);
    bool empty = true;
    for (std::size_t at = 3; at < tile.texels.size(); at += 4)
      empty = empty && tile.texels[at] == std::byte{0};
    if (empty) return;
    std::vector<std::byte> filled = tile.texels;
    fill_uncovered(filled, kImageSide);
    tile.bytes.resize(image_tile_bytes(bake.info_.format));
    encode_image(filled, bake.info_.format, std::span(tile.bytes).subspan(kImageHeadBytes), tile.error);
  }

  // False: it cannot be written.
  bool put(Tile& tile) {
    if (tile.bytes.empty()) return true;
    const NodeKey key = tile.key;
    ImageChildren children;
    for (int q = 0; q < 4; ++q) {
      const Quarter* const child =
          quarter(key.size - 1, std::int64_t{2} * key.x + (q & 1), std::int64_t{2} * key.z + (q >> 1));
      if (child != nullptr) children.places[q] = child->place;
    }
    const auto head = std::as_bytes(std::span(children.places));
    std::copy(head.begin(), head.end(), tile.bytes.begin());
    Quarter left;
    left.place = {ground.tile_bytes, static_cast<std::uint32_t>(tile.bytes.size()), crc32c(tile.bytes)};
    std::vector<std::byte> inside(std::size_t{4} * kImageInside * kImageInside);
    for (int y = 0; y < kImageInside; ++y) {
      const std::size_t from = texel_at(kImageSide, kImageBorder, y + kImageBorder);
      std::copy_n(tile.texels.begin() + static_cast<std::ptrdiff_t>(from), 4 * kImageInside,
                  inside.begin() + static_cast<std::ptrdiff_t>(texel_at(kImageInside, 0, y)));
    }
    left.texels.resize(std::size_t{4} * kHalf * kHalf);
    halve_texels(inside, kImageInside, left.texels);
    unwritten = !write(tile.bytes);
    if (unwritten) return false;
    ground.tile_bytes += tile.bytes.size();
    ground.tile_crc = crc32c(tile.bytes, ground.tile_crc);
    ++report.tiles;
    report.bytes += tile.bytes.size();
    if (tile.is_finest) {
      report.error.squares += tile.error.squares;
      report.error.values += tile.error.values;
    }
    levels[key.size].rows[key.z].emplace(key.x, std::move(left));
    return true;
  }
};

Error BakeImagery::run(WorldGround& ground, const Write& write, const ReportProgress& progress,
                       Report& report) {
  const auto start = std::chrono::steady_clock::now();
  Job job{*this, ground, write, progress, report, {}};
  Error error = job.run();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return error;
}

}  // namespace karst::bake
