// SPDX-License-Identifier: MIT
// Painting of a field's voxels: what a brush mixes, where it reaches, what is refused; taken back and done
// again to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#include "karst/edit.h"
#include "terrain/edit/brush.h"
#include "terrain/edit/field/paint_field.h"
#include "tests/support/field_shapes.h"

namespace karst::core {
namespace {

using test::field_info;
using test::fill_field;

constexpr glm::ivec3 kBlocks(4, 3, 4);
constexpr std::uint32_t kCount = 48;

struct Rock {
  // slots less than 0: there is no room for materials.
  explicit Rock(int slots, int cell_log2 = 13) : table(kCount), samples(kCount * 4096), undo(1 << 19) {
    if (slots >= 0) {
      material_table.resize(kCount);
      codes.resize(static_cast<std::size_t>(slots) * 4096);
    }
    field.create({table, samples, material_table, codes});
    FieldInfo info = field_info(kBlocks, kCount);
    info.cell_log2 = cell_log2;
    info.corner = {2, 0, 1};
    EXPECT_TRUE(field.reset(info).ok());
    // Solid below 25.3.
    fill_field(field, [](glm::dvec3 p) { return p.y - 25.3; });
    log.create(std::as_writable_bytes(std::span(undo)));
  }
  std::vector<int> all() const {
    std::vector<int> out;
    const glm::ivec3 n = kBlocks * 16;
    for (int z = 0; z < n.z; ++z) {
      for (int y = 0; y < n.y; ++y) {
        for (int x = 0; x < n.x; ++x) out.push_back(field.materials().at({x, y, z}));
      }
    }
    return out;
  }
  Status paint(const Edit& edit, std::span<std::uint32_t> kept_in = {}) {
    log.begin();
    const Status status = PaintField{&field, 8, kept_in, &log}.run(edit, changed);
    log.end();
    return status;
  }

  std::vector<std::uint32_t> table, material_table;
  std::vector<std::byte> samples;
  std::vector<std::uint8_t> codes;
  std::vector<std::uint64_t> undo;
  FieldBlocks field;
  UndoLog log;
  FieldChange changed;
};

Edit brush(glm::dvec3 place, double radius, std::uint8_t material, double amount = 1) {
  Edit edit;
  edit.tool = EditTool::paint;
  edit.place = place;
  edit.radius = radius;
  edit.material = material;
  edit.amount = amount;
  edit.hardness = 0.5;
  return edit;
}

TEST(PaintField, MixesTheTwoThatWeighMost) {
  EXPECT_EQ(mix_in(3, 5, 1), 5);
  EXPECT_EQ(mix_in(3, 5, 0), 3);
  EXPECT_EQ(mix_in(3, 5, 0.07), 3);  // less than half of a seventh
  EXPECT_EQ(mix_of(mix_in(3, 5, 0.08)), (MaterialMix{3, 5, 1}));
  EXPECT_EQ(mix_of(mix_in(5, 3, 3 / 7.0)), (MaterialMix{3, 5, 4}));
  EXPECT_EQ(mix_of(mix_in(0, 8, 0.5)).second, 8);
  // Of 3/7 the fourth and 4/7 the sixth, and then half of the first: 3/14 has no place.
  EXPECT_EQ(mix_of(mix_in(code_of({4, 6, 4}), 1, 0.5)), (MaterialMix{1, 6, 3}));
  // Every code with every material: valid, and nearer to it the more of it there is.
  for (unsigned c = 0; c < material_code::kCount; ++c) {
    for (unsigned m = 0; m <= 8; ++m) {
      int before = -1;
      for (int n = 0; n <= 20; ++n) {
        const std::uint8_t code = mix_in(static_cast<std::uint8_t>(c), m, n / 20.0);
        ASSERT_LT(code, material_code::kCount);
        const MaterialMix mix = mix_of(code);
        const int of_it = mix.first == m ? 7 - mix.sevenths : mix.second == m ? mix.sevenths : 0;
        ASSERT_GE(of_it, before);
        before = of_it;
      }
      ASSERT_EQ(before, 7);
    }
  }
}

TEST(PaintField, PaintsAsTheBrushWeighsAndNothingElse) {
  for (const int log2 : {13, 12}) {
    Rock rock(48, log2);
    const double cells = log2 == 13 ? 1 : 2;  // a voxel
    for (const BrushShape shape : {BrushShape::sphere, BrushShape::box}) {
      const std::vector<int> before = rock.all();
      Edit edit = brush(glm::dvec3(2, 0, 1) + glm::dvec3(30, 24, 29) / cells, 9 / cells,
                        shape == BrushShape::box ? 6 : 2, 0.8);
      edit.shape = shape;
      edit.half = glm::dvec3(5, 7, 4) / cells;
      ASSERT_TRUE(rock.paint(edit).ok());
      ASSERT_TRUE(rock.changed.changed);
      Edit own = edit;
      own.place = {30, 24, 29};
      own.radius = 9;
      own.half = {5, 7, 4};
      const std::vector<int> after = rock.all();
      std::size_t n = 0, painted = 0;
      for (int z = 0; z < 64; ++z) {
        for (int y = 0; y < 48; ++y) {
          for (int x = 0; x < 64; ++x, ++n) {
            // The blocks above have no rock.
            const double weight = y < 32 ? 0.8 * brush_weight(own, glm::dvec3(x, y, z)) : 0;
            ASSERT_EQ(after[n], mix_in(static_cast<std::uint8_t>(before[n]), edit.material + 1u, weight));
            painted += after[n] != before[n];
            if (after[n] == before[n]) continue;
            for (int axis = 0; axis < 3; ++axis) {
              ASSERT_GE((glm::ivec3{x, y, z})[axis], rock.changed.first[axis]);
              ASSERT_LE((glm::ivec3{x, y, z})[axis], rock.changed.last[axis]);
            }
          }
        }
      }
      EXPECT_GT(painted, 500u);
    }
  }
}

TEST(PaintField, IsTakenBackAndDoneAgainToTheBit) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(0, 1);
  for (const bool strokes : {false, true}) {
    Rock rock(20);
    rock.field.materials().fill({1, 1, 1}, 77);
    std::vector<std::uint32_t> kept_in(strokes ? kCount : 0);
    std::vector<std::vector<int>> states{rock.all()};
    for (int n = 0; n < 12; ++n) {
      rock.log.begin();
      // A stroke is several dabs in one step.
      for (int dab = 0; dab < (strokes ? 5 : 1); ++dab) {
        const Edit edit =
            brush({3 + 60 * any(random), 20 + 8 * any(random), 2 + 60 * any(random)}, 2 + 5 * any(random),
                  n % 5 == 4 ? kNoMaterial : static_cast<std::uint8_t>(n % 8));
        const Status status = PaintField{&rock.field, 8, kept_in, &rock.log}.run(edit, rock.changed);
        if (!status.ok()) {
          ASSERT_STREQ(status.field(), "field_material_blocks");
        }
      }
      rock.log.end();
      states.push_back(rock.all());
    }
    const auto exchange = [&](UndoPart part) { exchange_paint(rock.field, part, rock.changed); };
    std::size_t at = states.size() - 1;
    const std::uint32_t steps = rock.log.undo_steps();
    EXPECT_GT(steps, 8u);
    EXPECT_EQ(rock.log.lost_steps(), 0u);
    std::vector<std::vector<int>> seen{rock.all()};
    for (std::uint32_t n = 0; n < steps; ++n) {
      ASSERT_TRUE(rock.log.undo(exchange));
      EXPECT_TRUE(rock.changed.changed);
      while (at > 0 && states[at] == seen.back()) --at;
      seen.push_back(rock.all());
      ASSERT_EQ(seen.back(), states[at]) << n;
    }
    EXPECT_EQ(rock.all(), states[0]);
    EXPECT_EQ(rock.field.materials().free_blocks(), 20u);
    for (std::uint32_t n = steps; n-- > 0;) {
      ASSERT_TRUE(rock.log.redo(exchange));
      ASSERT_EQ(rock.all(), seen[n]) << n;
    }
  }
}

TEST(PaintField, RefusesWhatItCannotDoAndChangesNothing) {
  Rock rock(2), none(-1);
  const auto refused = [&](Rock& r, const Edit& edit) {
    const std::vector<int> before = r.field.materials().exists() ? r.all() : std::vector<int>();
    const Status status = r.paint(edit);
    EXPECT_FALSE(r.changed.changed);
    EXPECT_EQ(r.log.undo_steps(), 0u);
    EXPECT_EQ(r.field.materials().exists() ? r.all() : std::vector<int>(), before);
    return status.ok() ? std::string() : std::string(status.field());
  };
  const glm::dvec3 on_top(34, 25, 33);  // where four blocks meet, of which each takes codes
  const Edit good = brush(on_top, 3, 1);
  EXPECT_EQ(refused(rock, good), "field_material_blocks");
  EXPECT_EQ(rock.paint(good).value(), 2u);
  EXPECT_EQ(refused(none, good), "field_material_blocks");
  const auto with = [&](auto&& change) {
    Edit edit = good;
    change(edit);
    return refused(rock, edit);
  };
  EXPECT_EQ(with([](Edit& e) { e.tool = EditTool::clear; }), "tool");
  EXPECT_EQ(with([](Edit& e) { e.shape = BrushShape::voxel; }), "shape");
  EXPECT_EQ(with([](Edit& e) { e.radius = 129; }), "radius_m");
  EXPECT_EQ(with([](Edit& e) { e.radius = std::nan(""); }), "radius_m");
  EXPECT_EQ(with([](Edit& e) { e.place.y = 1e300; }), "place");
  EXPECT_EQ(with([](Edit& e) { e.shape = BrushShape::box, e.half.z = 0; }), "half_m");
  EXPECT_EQ(with([](Edit& e) { e.amount = 1.01; }), "amount");
  EXPECT_EQ(with([](Edit& e) { e.hardness = -1; }), "hardness");
  EXPECT_EQ(with([](Edit& e) { e.material = 8; }), "material");
  // Beside the field, in the air, or what is so already.
  EXPECT_EQ(refused(rock, brush({500, 10, 10}, 5, 1)), "");
  EXPECT_EQ(refused(rock, brush({34, 44, 33}, 5, 1)), "");
  EXPECT_EQ(refused(rock, brush(on_top, 5, kNoMaterial)), "");
  // Within one block there is room.
  EXPECT_TRUE(rock.paint(brush({26, 22, 25}, 3, 1)).ok());
  EXPECT_TRUE(rock.changed.changed);
}

TEST(PaintField, TellsTheMaterialOfTheRockAtAPlace) {
  Rock rock(48), none(-1);
  for (int b = 0; b < static_cast<int>(kCount); ++b) {
    const glm::ivec3 block(b % 4, b / 4 % 3, b / 12);
    for (int n = 0; n < 4096; ++n)
      rock.field.materials().open(block)[static_cast<std::size_t>(n)] =
          static_cast<std::uint8_t>((block * 16 + glm::ivec3(n & 15, n >> 4 & 15, n >> 8)).y);
  }
  // Rock ends between 25 and 26.
  EXPECT_EQ(material_at(rock.field, {10, 25.8, 10}), 25);
  EXPECT_EQ(material_at(rock.field, {10, 25.2, 10}), 25);
  EXPECT_EQ(material_at(rock.field, {10.4, 12.7, 10}), 13);
  EXPECT_EQ(material_at(rock.field, {10, 30.6, 10}), 31);  // in the air
  EXPECT_EQ(material_at(none.field, {10, 25.2, 10}), 0);
}

}  // namespace
}  // namespace karst::core
