// SPDX-License-Identifier: MIT
// Edits of the ground's samples: an edited ground is one that was made from the edited samples, bit by bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "terrain/edit/brush.h"
#include "terrain/edit/ground/edit_ground.h"
#include "terrain/lod/morph.h"
#include "tests/support/memory_ground.h"

namespace karst::core {
namespace {

using test::MemoryGround;

constexpr double kStep = 8192;  // a voxel from sample to sample

// A ground in memory, and its samples as edits leave them, one by one.
class Edited {
 public:
  Edited(std::int64_t wide, std::int64_t deep, std::uint32_t tiles)
      : wide_(wide),
        samples_(make_samples(wide, deep)),
        file_(wide, deep, kStep, kStep, heights(samples_)),
        source_(file_) {
    Budget budget;
    EditGround::add_to(budget, {tiles, 0});
    memory_.resize(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory_.data();
    std::size_t room = memory_.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    EXPECT_TRUE(editor.create({tiles, 0}, arena).ok());
    EXPECT_EQ(arena.used(), budget.cpu_bytes());
    editor.attach(
        file_.info(), file_.tile(tile_of(file_.root())), source_.source(),
        {&file_, [](const void* context, NodeKey key, const TilePlace&, std::span<std::byte>, Tile& out) {
           out = static_cast<const MemoryGround*>(context)->tile(key);
           return Status();
         }});
  }

  const MemoryGround& file() const { return file_; }
  MemoryGround::Heights heights(const std::vector<std::int32_t>& of) const {
    return [&of, wide = wide_](std::int64_t i, std::int64_t k) {
      return of[static_cast<std::size_t>(k * wide + i)];
    };
  }
  const Tile& tile(NodeKey key) const {
    const EditedTile* const edited = editor.overlay().find(key);
    return edited != nullptr ? edited->tile : file_.tile(key);
  }
  // Of all samples, by the tiles of size 0.
  std::vector<std::int32_t> samples() const {
    std::vector<std::int32_t> all(samples_.size());
    const std::int64_t deep = static_cast<std::int64_t>(all.size()) / wide_;
    for (std::int64_t k = 0; k < deep; ++k) {
      for (std::int64_t i = 0; i < wide_; ++i) {
        const std::int64_t x = std::min(i / kTileQuads, (wide_ - 2) / kTileQuads);
        const std::int64_t z = std::min(k / kTileQuads, (deep - 2) / kTileQuads);
        all[static_cast<std::size_t>(k * wide_ + i)] =
            tile({0, static_cast<int>(x), static_cast<int>(z)})
                .height(static_cast<int>(i - x * kTileQuads), static_cast<int>(k - z * kTileQuads));
      }
    }
    return all;
  }

  // Heights and measures of all tiles of all sizes.
  std::vector<std::byte> facts() const {
    std::vector<std::byte> all;
    const auto put = [&](const auto& value) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      all.insert(all.end(), bytes, bytes + sizeof value);
    };
    const GroundInfo& info = file_.info();
    for (int size = 0; size <= info.top_size(); ++size) {
      for (int z = 0; z <= (nodes_along(info, 1, size) - 1) / kTileNodes; ++z) {
        for (int x = 0; x <= (nodes_along(info, 0, size) - 1) / kTileNodes; ++x) {
          const Tile& one = tile({size, x, z});
          put(one.heights);
          for (const NodeMeasure& node : one.nodes) {
            put(node.low);
            put(node.high);
            put(node.thresholds);
          }
        }
      }
    }
    return all;
  }

  EditGround editor;

 private:
  static std::vector<std::int32_t> make_samples(std::int64_t wide, std::int64_t deep) {
    std::vector<std::int32_t> out;
    std::mt19937 random(7);
    for (std::int64_t k = 0; k < deep; ++k) {
      for (std::int64_t i = 0; i < wide; ++i) {
        out.push_back(static_cast<std::int32_t>(9000 * std::sin(0.05 * static_cast<double>(i)) *
                                                std::cos(0.03 * static_cast<double>(k))) +
                      static_cast<std::int32_t>(random() % 600));
      }
    }
    return out;
  }

  std::int64_t wide_;
  std::vector<std::int32_t> samples_;
  MemoryGround file_;
  MemoryGround::Source source_;
  std::vector<std::byte> memory_;
};

Edit random_edit(std::mt19937& random, double wide, double deep) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr EditTool kTools[] = {EditTool::extrude, EditTool::smooth, EditTool::noise, EditTool::flatten,
                                 EditTool::level};
  constexpr BrushShape kShapes[] = {BrushShape::sphere, BrushShape::cylinder, BrushShape::box,
                                    BrushShape::capsule};
  Edit edit;
  edit.tool = kTools[random() % 5];
  edit.shape = kShapes[random() % 4];
  edit.place = {between(-3, wide + 3), between(-2, 2), between(-3, deep + 3)};
  edit.to = edit.place + glm::dvec3(between(-9, 9), 0, between(-9, 9));
  edit.half = {between(1, 9), 4, between(1, 9)};
  edit.up = {between(-0.3, 0.3), 1, between(-0.3, 0.3)};
  edit.radius = between(1, 12);
  edit.strength = between(-1, 1);
  edit.amount = between(0, 1);
  edit.hardness = between(0, 1);
  edit.wave = between(2, 20);
  edit.seed = static_cast<std::uint32_t>(random());
  return edit;
}

// Heights and least and greatest ones of all sizes, thresholds of those that follow from samples alone; of
// coarser ones that none is less than what is made of the samples. Returns how many thresholds differ.
std::size_t expect_as_made(const Edited& edited, const char* when) {
  const std::vector<std::int32_t> samples = edited.samples();
  const GroundInfo& info = edited.file().info();
  const MemoryGround made(info.samples[0], info.samples[1], info.steps[0], info.steps[1],
                          edited.heights(samples));
  EXPECT_EQ(edited.editor.info().low, made.info().low) << when;
  EXPECT_EQ(edited.editor.info().high, made.info().high) << when;
  std::size_t off = 0;
  for (int size = 0; size <= info.top_size(); ++size) {
    for (int z = 0; z <= (nodes_along(info, 1, size) - 1) / kTileNodes; ++z) {
      for (int x = 0; x <= (nodes_along(info, 0, size) - 1) / kTileNodes; ++x) {
        const Tile& own = edited.tile({size, x, z});
        const Tile& other = made.tile({size, x, z});
        EXPECT_EQ(std::memcmp(own.heights, other.heights, sizeof own.heights), 0)
            << when << ": heights of " << size << " " << x << " " << z;
        for (int n = 0; n < kTileMeasures; ++n) {
          EXPECT_EQ(own.nodes[n].low, other.nodes[n].low)
              << when << " " << size << " " << x << " " << z << " " << n;
          EXPECT_EQ(own.nodes[n].high, other.nodes[n].high) << when << " " << size;
          for (std::size_t d = 0; d < kDemands; ++d) {
            if (size <= kReferenceSizes) {
              EXPECT_EQ(own.nodes[n].thresholds[d], other.nodes[n].thresholds[d])
                  << when << ": node " << n << " of " << size << " " << x << " " << z;
            } else {
              off += own.nodes[n].thresholds[d] != other.nodes[n].thresholds[d] ? 1 : 0;
            }
          }
          if (testing::Test::HasFailure()) return off;
        }
      }
    }
  }
  return off;
}

TEST(EditGround, IsAsAGroundMadeOfTheEditedSamples) {
  for (const auto& [wide, deep] : {std::pair<int, int>{150, 190}, {257, 129}, {300, 280}}) {
    Edited edited(wide, deep, 200);
    std::mt19937 random(static_cast<unsigned>(wide));
    int changed = 0;
    for (int n = 0; n < 300; ++n) {
      GroundChange change;
      const Status status = edited.editor.apply(random_edit(random, wide, deep), nullptr, change);
      ASSERT_TRUE(status.ok()) << status.what() << " " << status.field();
      changed += change.changed ? 1 : 0;
      if (n % 60 != 59 && n > 2) continue;
      expect_as_made(edited, "after an edit");
      ASSERT_FALSE(HasFailure()) << n;
    }
    EXPECT_GT(changed, 150);
  }
}

// What sizes beyond the exact ones state is no less than what is there: the samples' deviation from the
// size's own surface, home, at all samples of a node.
TEST(EditGround, CoarseSizesNeverSayLessThanIsThere) {
  Edited edited(300, 280, 200);
  std::mt19937 random(3);
  for (int n = 0; n < 200; ++n) {
    Edit edit = random_edit(random, 300, 280);
    edit.strength *= 3;
    GroundChange change;
    ASSERT_TRUE(edited.editor.apply(edit, nullptr, change).ok());
  }
  const std::vector<std::int32_t> samples = edited.samples();
  const GroundInfo& info = edited.file().info();
  const auto at = [&](std::int64_t i, std::int64_t k) {
    return 2.0 * samples[static_cast<std::size_t>(std::min<std::int64_t>(k, 279) * 300 +
                                                  std::min<std::int64_t>(i, 299))];
  };
  ASSERT_GT(info.top_size(), kReferenceSizes);
  int nodes = 0, raised = 0;
  for (int size = kReferenceSizes + 1; size <= info.top_size(); ++size) {
    const std::int64_t unit = std::int64_t{1} << size;
    for (int z = 0; z < nodes_along(info, 1, size); ++z) {
      for (int x = 0; x < nodes_along(info, 0, size); ++x) {
        double most = 0;
        for (std::int64_t qz = 4 * z; qz < 4 * z + 4 && (qz + 1) * unit < 280; ++qz) {
          for (std::int64_t qx = 4 * x; qx < 4 * x + 4 && (qx + 1) * unit < 300; ++qx) {
            const double a = at(qx * unit, qz * unit), b = at((qx + 1) * unit, qz * unit);
            const double c = at(qx * unit, (qz + 1) * unit), d = at((qx + 1) * unit, (qz + 1) * unit);
            for (std::int64_t k = 0; k <= unit; ++k) {
              for (std::int64_t i = 0; i <= unit; ++i) {
                const double u = static_cast<double>(i) / static_cast<double>(unit);
                const double v = static_cast<double>(k) / static_cast<double>(unit);
                double own = 0;
                if (((qx + qz) & 1) == 0) {
                  own = u >= v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
                } else {
                  own =
                      u + v <= 1 ? a + u * (b - a) + v * (c - a) : d + (1 - u) * (c - d) + (1 - v) * (b - d);
                }
                most = std::max(most, std::abs(at(qx * unit + i, qz * unit + k) - own));
              }
            }
          }
        }
        const NodeKey key{size, x, z};
        const NodeMeasure& own = edited.tile(tile_of(key)).nodes[node_in_tile(key)];
        const NodeMeasure& file = edited.file().tile(tile_of(key)).nodes[node_in_tile(key)];
        ++nodes;
        raised += own.thresholds[4] > file.thresholds[4] ? 1 : 0;
        for (int n = 0; n < kDemands; ++n) {
          const double steps =
              double{threshold_steps(own.thresholds[n])} * std::ldexp(1.0, info.page_size(size));
          EXPECT_GE(steps, demand(n) * most) << size << " " << x << " " << z << " " << n;
        }
      }
    }
  }
  EXPECT_GT(nodes, 2);
  EXPECT_GT(raised, 0);
}

// Steps of one edit and of many, close to each other and far apart: also what coarse sizes keep of the file.
TEST(EditGround, StepsAreTakenBackAndAgainToTheBit) {
  Edited edited(300, 280, 128);
  std::vector<std::uint64_t> memory(1 << 20);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  std::mt19937 random(11);
  std::vector<std::vector<std::byte>> states = {edited.facts()};
  std::uint64_t edits = 0, parts = 0;
  GroundChange change;
  for (int n = 0; n < 40; ++n) {
    bool changed = false;
    Edit edit = random_edit(random, 300, 280);
    log.begin();
    const std::uint64_t first = log.part_number();
    for (int dab = n % 2 == 0 ? 0 : n; dab >= 0; --dab) {
      ASSERT_TRUE(edited.editor.apply(edit, &log, change).ok());
      changed = changed || change.changed;
      edits += change.changed;
      // A line of dabs, or here and there.
      if (n % 4 == 1) {
        edit = random_edit(random, 300, 280);
      } else {
        edit.place += glm::dvec3(2, 0, 1);
        edit.to += glm::dvec3(2, 0, 1);
      }
    }
    log.end();
    parts += log.part_number() - first;
    if (changed) states.push_back(edited.facts());
  }
  EXPECT_GT(parts, 60u) << "of " << edits;
  EXPECT_LT(parts, edits * 6 / 10) << "of " << edits;
  ASSERT_EQ(log.undo_steps(), states.size() - 1);
  ASSERT_EQ(log.lost_steps(), 0u);
  const auto exchange = [&](UndoPart part) { edited.editor.exchange(part, change); };
  for (int round = 0; round < 2; ++round) {
    for (std::size_t n = states.size() - 1; n > 0; --n) {
      ASSERT_TRUE(log.undo(exchange));
      ASSERT_TRUE(edited.facts() == states[n - 1]) << n;
    }
    EXPECT_EQ(expect_as_made(edited, "after all was taken back"), 0u);
    for (std::size_t n = 1; n < states.size(); ++n) {
      ASSERT_TRUE(log.redo(exchange));
      ASSERT_TRUE(edited.facts() == states[n]) << n;
    }
    expect_as_made(edited, "after all was done again");
  }
}

TEST(EditGround, ErrorsChangeNothing) {
  Edited edited(150, 129, 9);
  const std::vector<std::int32_t> before = edited.samples();
  std::vector<std::uint64_t> memory(1 << 12);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Edit good;
  good.tool = EditTool::extrude;
  good.shape = BrushShape::cylinder;
  good.place = {20, 0, 20};
  good.radius = 5;
  const auto refuse = [&](const char* field, const Edit& edit) {
    GroundChange change;
    log.begin();
    const Status status = edited.editor.apply(edit, &log, change);
    EXPECT_EQ(log.open_part(), CellKind::none) << field;
    log.end();
    EXPECT_EQ(log.undo_steps() + log.lost_steps(), 0u) << field;
    EXPECT_FALSE(status.ok()) << field;
    EXPECT_STREQ(status.field(), field);
    EXPECT_FALSE(change.changed);
    EXPECT_EQ(edited.samples(), before) << field;
  };
  const auto with = [&](auto Edit::*member, auto value) {
    Edit edit = good;
    edit.*member = value;
    return edit;
  };
  refuse("tool", with(&Edit::tool, EditTool::paint));
  refuse("shape", with(&Edit::shape, BrushShape::voxel));
  refuse("place", with(&Edit::place, glm::dvec3(nan, 0, 0)));
  refuse("radius_m", with(&Edit::radius, 0.0));
  refuse("radius_m", with(&Edit::radius, nan));
  refuse("strength_m", with(&Edit::strength, nan));
  refuse("strength_m", with(&Edit::strength, 1e6));
  refuse("strength_m", with(&Edit::strength, 200.0));  // too steep
  refuse("amount", with(&Edit::amount, 1.5));
  refuse("hardness", with(&Edit::hardness, -0.1));
  Edit noise = with(&Edit::tool, EditTool::noise);
  noise.wave = 0;
  refuse("wave_m", noise);
  Edit flat = with(&Edit::tool, EditTool::flatten);
  flat.up = {1, 0, 0};
  refuse("up", flat);
  // All of the ground, in a pool that is too small: nothing that was kept is lost for it.
  refuse("edit_tiles", with(&Edit::radius, 1e300));
  GroundChange change;
  const Status status = edited.editor.apply(with(&Edit::radius, 1e300), nullptr, change);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "edit_tiles");
  EXPECT_GT(status.value(), 9u);
  EXPECT_EQ(edited.samples(), before);
  // Beside the ground nothing happens; what is asked for in the middle does.
  EXPECT_TRUE(edited.editor.apply(with(&Edit::place, glm::dvec3(-900, 0, 0)), nullptr, change).ok());
  EXPECT_FALSE(change.changed);
  EXPECT_TRUE(edited.editor.apply(good, nullptr, change).ok());
  EXPECT_TRUE(change.changed);
}

TEST(EditGround, SimplexNoiseStaysWithinOneAndIsContinuous) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-50, 50);
  double least = 0, most = 0, sum = 0;
  for (int n = 0; n < 200'000; ++n) {
    const glm::dvec3 place(any(random), any(random), any(random));
    const double value = simplex_noise(place, 9);
    least = std::min(least, value);
    most = std::max(most, value);
    sum += value;
    ASSERT_NEAR(simplex_noise(place + glm::dvec3(1e-7, -1e-7, 1e-7), 9), value, 1e-5);
  }
  EXPECT_LT(most, 1.0) << "clamped";
  EXPECT_GT(least, -1.0) << "clamped";
  EXPECT_GT(most, 0.8);
  EXPECT_LT(least, -0.8);
  EXPECT_NEAR(sum / 200'000, 0, 0.01);
}

}  // namespace
}  // namespace karst::core
