// SPDX-License-Identifier: MIT
// What the bake measures of nodes, against slow looks at all samples: no state of the morph is further from
// the surface of all samples than it says.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <tuple>
#include <vector>

#include "bake/ground/ground_pyramid.h"
#include "terrain/lod/morph.h"
#include "tiles/decode_tile.h"
#include "tiles/tile_bytes.h"

namespace karst {
namespace {

using namespace core;

constexpr double kG = 1.1547005383792517;

struct Field {
  const char* name;
  int wide, deep;
  double step_x, step_z;
  std::int32_t rough;  // of a step between samples, kVertexStep
};

class BakedField {
 public:
  BakedField(const Field& field, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::int32_t> step(-field.rough, field.rough);
    GroundInfo info;
    info.samples[0] = field.wide;
    info.samples[1] = field.deep;
    info.steps[0] = field.step_x;
    info.steps[1] = field.step_z;
    for (int k = 0; k < field.deep; ++k) {
      for (int i = 0; i < field.wide; ++i) {
        const double hill = 6.0 * field.rough * (std::sin(i / 5.0) + std::cos(k / 7.0));
        heights_.push_back(static_cast<std::int32_t>(hill) + step(random));
      }
    }
    std::vector<std::byte> all;
    bake::GroundPyramid pyramid(info, {}, 0, 1, [&](std::span<const std::byte> bytes) {
      all.insert(all.end(), bytes.begin(), bytes.end());
      return true;
    });
    const auto width = static_cast<std::size_t>(field.wide);
    for (std::size_t k = 0; k < static_cast<std::size_t>(field.deep); ++k) {
      const auto outcome = pyramid.push(std::span<const std::int32_t>(heights_).subspan(k * width, width));
      EXPECT_EQ(outcome, bake::GroundPyramid::Outcome::ok);
    }
    pyramid.finish();
    info_ = pyramid.ground().info;
    EXPECT_EQ(all.size(), pyramid.ground().tile_bytes);
    read({info_.top_size(), 0, 0}, pyramid.ground().root, all);
    EXPECT_EQ(tiles_.size(), pyramid.tiles());
  }

  const GroundInfo& info() const { return info_; }
  const NodeMeasure* measure(NodeKey node) const {
    if (!node_exists(info_, node)) return nullptr;
    const NodeKey tile = tile_of(node);
    return &tiles_.at({tile.size, tile.x, tile.z}).nodes[node_in_tile(node)];
  }
  const std::map<std::tuple<int, int, int>, Tile>& tiles() const { return tiles_; }

  std::int32_t sample(std::int64_t i, std::int64_t k) const {
    return heights_[static_cast<std::size_t>(k * info_.samples[0] + i)];
  }
  // Of the grid of a size, in steps.
  struct Point {
    double x, y, z;
  };
  Point vertex(int size, std::int64_t i, std::int64_t k) const {
    const std::int64_t a = sample_of(info_.samples[0], size, i);
    const std::int64_t b = sample_of(info_.samples[1], size, k);
    return {static_cast<double>(a) * info_.steps[0], 2.0 * sample(a, b),
            static_cast<double>(b) * info_.steps[1]};
  }
  // The full surface, over a place in it.
  double full(double x, double z) const {
    const double u = x / info_.steps[0];
    const double v = z / info_.steps[1];
    const auto cell = [](double at, std::int64_t samples) {
      return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(at)), 0, samples - 2);
    };
    const std::int64_t i = cell(u, info_.samples[0]);
    const std::int64_t k = cell(v, info_.samples[1]);
    const double a = u - static_cast<double>(i);
    const double b = v - static_cast<double>(k);
    const double nw = 2.0 * sample(i, k), ne = 2.0 * sample(i + 1, k);
    const double sw = 2.0 * sample(i, k + 1), se = 2.0 * sample(i + 1, k + 1);
    if (((i + k) & 1) == 0)
      return a >= b ? nw + a * (ne - nw) + b * (se - ne) : nw + b * (sw - nw) + a * (se - sw);
    return a + b <= 1 ? nw + a * (ne - nw) + b * (sw - nw) : se + (1 - a) * (sw - se) + (1 - b) * (ne - se);
  }

 private:
  void read(NodeKey key, const TilePlace& place, const std::vector<std::byte>& all) {
    std::vector<std::byte> room(tiles::decode_tile_room());
    Tile& tile = tiles_[{key.size, key.x, key.z}];
    const auto bytes = std::span(all).subspan(static_cast<std::size_t>(place.offset), place.bytes);
    const Status status = tiles::decode_tile(info_, key, place, bytes, room, tile);
    ASSERT_TRUE(status.ok()) << status.what();
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (tile.children[quadrant].exists()) read(key.child(quadrant), tile.children[quadrant], all);
    }
  }

  GroundInfo info_;
  std::vector<std::int32_t> heights_;
  std::map<std::tuple<int, int, int>, Tile> tiles_;
};

const Field kFields[] = {
    {"divides", 65, 65, 2048, 2048, 300},    {"does not", 39, 58, 2048, 2048, 300},
    {"one short", 64, 33, 1024, 1024, 2000}, {"one more", 66, 34, 2048, 1311.7, 50},
    {"narrow", 3, 70, 777.7, 2048, 500},     {"large", 300, 271, 2048, 2048, 900},
    {"smallest", 2, 2, 2048, 2048, 300},
};

TEST(MeasureGround, TilesHoldTheSamples) {
  for (const Field& field : kFields) {
    const BakedField baked(field, 1);
    for (const auto& [key, tile] : baked.tiles()) {
      const auto [size, x, z] = key;
      for (int k = -kTileRim; k <= kTileQuads + kTileRim; ++k) {
        for (int i = -kTileRim; i <= kTileQuads + kTileRim; ++i) {
          const double wanted = baked.vertex(size, x * kTileQuads + i, z * kTileQuads + k).y;
          ASSERT_EQ(2.0 * tile.height(i, k), wanted) << field.name << " size " << size;
        }
      }
    }
  }
}

TEST(MeasureGround, NodesKnowTheirLeastAndGreatestHeight) {
  for (const Field& field : kFields) {
    const BakedField baked(field, 2);
    const GroundInfo& info = baked.info();
    for (int size = 0; size <= info.top_size(); ++size) {
      for (int z = 0; node_exists(info, {size, 0, z}); ++z) {
        for (int x = 0; node_exists(info, {size, x, z}); ++x) {
          std::int32_t low = INT32_MAX;
          std::int32_t high = INT32_MIN;
          const auto end = [&](int axis, int at) {
            return sample_of(info.samples[axis], size, (at + 1) * 4ll);
          };
          for (std::int64_t k = std::int64_t{z} * 4 << size; k <= end(1, z); ++k) {
            for (std::int64_t i = std::int64_t{x} * 4 << size; i <= end(0, x); ++i) {
              low = std::min(low, baked.sample(i, k));
              high = std::max(high, baked.sample(i, k));
            }
          }
          ASSERT_EQ(baked.measure({size, x, z})->low, low)
              << field.name << ' ' << size << ' ' << x << ' ' << z;
          ASSERT_EQ(baked.measure({size, x, z})->high, high);
        }
      }
    }
  }
}

// D of a node at a demand, in steps of size 0.
double threshold(const NodeMeasure& measure, int size, int demand) {
  return std::ldexp(double{threshold_steps(measure.thresholds[demand])}, size);
}

// (2) of ground_view.h; nodes of size 0 are not split.
TEST(MeasureGround, ThresholdsAreFarEnoughApart) {
  for (const Field& field : kFields) {
    const BakedField baked(field, 3);
    const GroundInfo& info = baked.info();
    for (int size = 2; size <= info.top_size(); ++size) {
      for (int z = 0; node_exists(info, {size, 0, z}); ++z) {
        for (int x = 0; node_exists(info, {size, x, z}); ++x) {
          const NodeMeasure& p = *baked.measure({size, x, z});
          for (int n = 0; n < 16; ++n) {
            const NodeMeasure* const q = baked.measure({size - 1, 2 * x - 1 + n % 4, 2 * z - 1 + n / 4});
            if (q == nullptr) continue;
            const double side = std::ldexp(kNodeQuads, size - 1);
            const double rise =
                kG * std::sqrt(std::pow(side * info.steps[0], 2) + std::pow(side * info.steps[1], 2) +
                               std::pow(2.0 * (double(q->high) - q->low), 2));
            for (int d = 0; d < kDemands; ++d) {
              const double own = threshold(p, size, d);
              ASSERT_GE(own * (1 - double{kNodeMorphShare}), threshold(*q, size - 1, d) + rise)
                  << field.name << " size " << size << " demand " << d;
            }
          }
        }
      }
    }
  }
}

// A family of p drawn with any shares of the morph, and its border with others.
TEST(MeasureGround, NoStateIsFurtherFromAllSamplesThanItSays) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (const Field& field : kFields) {
    const BakedField baked(field, 5);
    const GroundInfo& info = baked.info();
    double ratio[4] = {};
    for (int size = 1; size <= std::min(info.top_size(), 3); ++size) {
      for (int z = 0; node_exists(info, {size, 0, z}); ++z) {
        for (int x = 0; node_exists(info, {size, x, z}); ++x) {
          // What it says: D, which is a little more, over the greatest demand.
          const NodeMeasure& measure = *baked.measure({size, x, z});
          const double error = threshold(measure, size, kDemands - 1) / demand(kDemands - 1);
          for (int state = 0; state < 6; ++state) {
            BakedField::Point drawn[9][9];
            for (int k = 0; k < 9; ++k) {
              for (int i = 0; i < 9; ++i) {
                const std::int64_t a = 8 * x + i;
                const std::int64_t b = 8 * z + k;
                const BakedField::Point home = baked.vertex(size - 1, a, b);
                // Its parents, in the grid of the node's size.
                std::int64_t i0 = a >> 1, i1 = (a + 1) >> 1;
                const std::int64_t k0 = b >> 1, k1 = (b + 1) >> 1;
                if ((a & b & 1) != 0 && ((i0 + k0) & 1) != 0) std::swap(i0, i1);
                const BakedField::Point one = baked.vertex(size, i0, k0);
                const BakedField::Point other = baked.vertex(size, i1, k1);
                const double share = state == 0   ? 0
                                     : state == 1 ? 1
                                     : state < 4  ? double(random() % 2)
                                                  : any(random);
                const auto mix = [&](double from, double c, double d) {
                  return from + share * ((c + d) / 2 - from);
                };
                drawn[k][i] = {mix(home.x, one.x, other.x), mix(home.y, one.y, other.y),
                               mix(home.z, one.z, other.z)};
              }
            }
            const auto look = [&](const BakedField::Point& a, const BakedField::Point& b,
                                  const BakedField::Point& c) {
              for (int n = 0; n < 9; ++n) {
                double u = n < 3 ? double(n == 0) : any(random), v = n < 3 ? double(n == 1) : any(random);
                if (u + v > 1) u = 1 - u, v = 1 - v;
                const double w = 1 - u - v;
                const double off =
                    std::abs(u * a.y + v * b.y + w * c.y -
                             baked.full(u * a.x + v * b.x + w * c.x, u * a.z + v * b.z + w * c.z));
                ratio[size] = std::max(ratio[size], off / error);
                ASSERT_LE(off, error) << field.name << " size " << size << " node " << x << ' ' << z;
              }
            };
            for (int k = 0; k < 8; ++k) {
              for (int i = 0; i < 8; ++i) {
                const bool even = ((i + k) & 1) == 0;
                const auto& nw = drawn[k][i];
                const auto& ne = drawn[k][i + 1];
                const auto& sw = drawn[k + 1][i];
                const auto& se = drawn[k + 1][i + 1];
                look(nw, ne, even ? se : sw);
                look(even ? nw : ne, sw, se);
                if (HasFatalFailure()) return;
              }
            }
          }
        }
      }
    }
    std::printf(
        "[          ] %s: greatest share of the stated error that is used at sizes 1, 2, 3: %.2f, %.2f, "
        "%.2f\n",
        field.name, ratio[1], ratio[2], ratio[3]);
    if (info.top_size() > 2) {
      EXPECT_GT(ratio[1], 0.3);
    }
  }
}

}  // namespace
}  // namespace karst
