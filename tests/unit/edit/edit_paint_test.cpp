// SPDX-License-Identifier: MIT
// Paint in the core: weights after each dab, which patches are drawn with the map, saving, and steps back.
#include "terrain/edit/paint/edit_paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "terrain/edit/brush.h"
#include "terrain/edit/save_world.h"
#include "terrain/world/terrain_parts.h"
#include "tests/support/heap_count.h"
#include "tests/support/test_world.h"
#include "tests/support/world_io.h"

namespace karst::core {
namespace {

using test::TestWorld;

constexpr std::uint32_t kWidth = 50, kDepth = 37;

// Six materials, and the map of them that is given; some patches have a material of their own.
std::vector<std::byte> file_of(const BlendMap& map = {}, std::span<const std::byte> texels = {},
                               std::span<const std::uint8_t> overrides = {}) {
  const TestWorld shape = TestWorld::noise(3, {14, 11, 13}, 0.45, 5.0, false);
  const std::vector<std::byte> plain = shape.file();
  MaterialSet set;
  set.count = 6;
  set.side = 16;
  for (std::uint32_t m = 0; m < set.count; ++m) std::strcpy(set.materials[m].name, m % 2 == 0 ? "a" : "b");
  for (std::uint32_t m = 0; m < set.count; ++m) set.materials[m].name[1] = static_cast<char>('0' + m);
  set.blend_map = map;
  const std::vector<std::byte> textures(texture_bytes(set));
  WorldMaterials materials{set, textures, overrides};
  materials.blend_map = texels;
  std::vector<std::byte> file;
  const Status status = write_world({shape.info(), &shape.octree(), read_patches(plain), materials}, file);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return file;
}

class Painted : public TerrainParts {
 public:
  explicit Painted(std::vector<std::byte> bytes, std::uint32_t width = kWidth, std::uint32_t depth = kDepth)
      : file_(std::move(bytes)) {
    WorldReader reader;
    EXPECT_TRUE(reader.open(ByteSource::of(file_)).ok());
    Config config = World::config_for(reader.info(), reader.info().level, reader.ground());
    config.paint_width = width;
    config.paint_depth = depth;
    memory_ = test::AlignedBytes(static_cast<std::size_t>(terrain_budget(config).cpu_bytes()));
    Status status = create(config, memory_.bytes());
    if (status.ok()) status = load(ByteSource::of(file_));
    EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  }
  std::vector<std::byte> save() const {
    std::vector<std::byte> out;
    std::vector<PatchId> room(world.patch_count());
    const auto append = [&](std::span<const std::byte> bytes) {
      out.insert(out.end(), bytes.begin(), bytes.end());
      return true;
    };
    EXPECT_TRUE(SaveWorld({&world, nullptr, room}).run(ByteSink::to(append)).ok());
    return out;
  }
  BlendSpan span() const { return blend_span(world.info(), world.ground()); }
  std::vector<int> texels() const {
    std::vector<int> out;
    for (const std::byte byte : world.painted_texels()) out.push_back(std::to_integer<int>(byte));
    return out;
  }

 private:
  std::vector<std::byte> file_;
  test::AlignedBytes memory_{0};
};

Edit random_dab(test::Random& random, glm::ivec3 extent, int materials) {
  Edit edit;
  edit.tool = EditTool::paint;
  edit.shape = static_cast<BrushShape>(1 + random.below(4));
  edit.place = glm::dvec3(extent) * glm::dvec3(random.unit(), 40 * random.unit(), random.unit());
  edit.to = edit.place + 5.0 * (glm::dvec3(random.unit(), random.unit(), random.unit()) - 0.5);
  edit.half = glm::dvec3(random.unit(), 0, random.unit()) * 3.0 + 0.1;
  edit.radius = 0.2 + 3 * random.unit();
  edit.amount = random.below(3) == 0 ? 1 : random.unit();
  edit.hardness = random.unit();
  const int material = random.below(materials + 1);
  edit.material = material == materials ? kNoPaint : static_cast<std::uint8_t>(material);
  return edit;
}

// Marks as karst-bake makes them: of every texel within the map's reach around the patch's box.
void expect_marks(const Painted& live) {
  const World& world = live.world;
  const BlendMap& map = world.materials().blend_map;
  const std::vector<int> texels = live.texels();
  const glm::ivec3 extent = world.info().extent;
  for (PatchId p = 0; p < world.patch_count(); ++p) {
    const LatticeBox box = patch_box(world.surface(), world.bounds(), p);
    const auto range = [&](int axis, std::uint32_t count) {
      const double scale = count / (extent[axis] - 1.0);
      const double low = (box.min[axis] / double{kStepsPerVoxel} - 0.5) * scale - 13;
      const double high = (box.max[axis] / double{kStepsPerVoxel} - 0.5) * scale + 13;
      return std::pair(std::max(0, static_cast<int>(std::floor(low))),
                       std::min(static_cast<int>(count), static_cast<int>(std::ceil(high))));
    };
    const auto x = range(0, map.width), z = range(2, map.depth);
    bool any = false;
    for (int k = z.first; k < z.second; ++k) {
      for (int i = x.first; i < x.second; ++i) {
        for (int c = 0; c < 4; ++c)
          any = any || texels[static_cast<std::size_t>((k * static_cast<int>(map.width) + i) * 4 + c)] != 0;
      }
    }
    ASSERT_EQ(world.material_overrides()[p] == kPaintedByMap, any) << p;
  }
}

TEST(EditPaint, WeightsAreWhatEachDabSays) {
  test::Random random{17};
  Painted live(file_of());
  World& world = live.world;
  const BlendMap& map = world.materials().blend_map;
  const BlendSpan span = live.span();
  int changed = 0, wiped = 0;
  for (int dab = 0; dab < 250; ++dab) {
    const std::vector<int> before = live.texels();
    const Edit edit = random_dab(random, world.info().extent, 4);
    PaintChange change;
    const std::size_t heap = test::heap_calls();
    const Status status = edit_paint(world, span, edit, nullptr, change);
    EXPECT_EQ(test::heap_calls(), heap);
    ASSERT_TRUE(status.ok()) << status.what();
    const std::vector<int> after = live.texels();
    ASSERT_EQ(change.changed, before != after);
    if (!change.changed) continue;
    ++changed;
    wiped += edit.material == kNoPaint;
    Edit flat = edit;
    flat.place.y = flat.to.y = 0;
    flat.half.y = 1;
    for (std::uint32_t z = 0; z < map.depth; ++z) {
      for (std::uint32_t x = 0; x < map.width; ++x) {
        const glm::dvec3 place(0.5 + (x + 0.5) / map.width * (world.info().extent.x - 1), 0,
                               0.5 + (z + 0.5) / map.depth * (world.info().extent.z - 1));
        const double share = brush_weight(flat, place) * edit.amount;
        const std::size_t at = std::size_t{4} * (z * map.width + x);
        int sum = 0;
        for (std::size_t c = 0; c < 4; ++c) {
          const int was = before[at + c], is = after[at + c];
          sum += is;
          if (is != was) {
            ASSERT_TRUE(x >= change.texels.low.x && x < change.texels.high.x);
            ASSERT_TRUE(z >= change.texels.low.y && z < change.texels.high.y);
          }
          const double towards = map.materials[c] == edit.material + 1 ? 255 : 0;
          ASSERT_NEAR(is, was + (towards - was) * share, 1.51) << dab;
          ASSERT_TRUE(share > 0 || is == was);
        }
        ASSERT_LE(sum, 255);
      }
    }
    if (dab % 20 == 0) {
      expect_marks(live);
      const std::vector<std::byte> saved = live.save();
      const Painted again(saved);
      ASSERT_EQ(again.texels(), after);
      ASSERT_TRUE(again.save() == saved);
      ASSERT_TRUE(std::ranges::equal(again.world.material_overrides(), world.material_overrides()));
    }
    if (testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(changed, 200);
  EXPECT_GT(wiped, 20);
}

TEST(EditPaint, StepsAreTakenBackToTheBit) {
  test::Random random{5};
  // With a map of the file's, and without.
  std::vector<std::byte> texels(std::size_t{kWidth} * kDepth * 4);
  for (std::size_t at = 0; at < 4 * 300; at += 4) texels[at + at / 4 % 2] = std::byte{200};
  Painted first(file_of());
  Painted marked(file_of({kWidth, kDepth, {2, 4, 0, 0}}, texels));
  std::vector<PatchId> all(marked.world.patch_count());
  for (PatchId p = 0; p < all.size(); ++p) all[p] = p;
  EXPECT_TRUE(mark_painted(marked.world, marked.span(), all));
  for (const std::vector<std::byte>& file : {first.save(), marked.save()}) {
    Painted live(file);
    ASSERT_TRUE(live.save() == file);
    std::vector<std::uint64_t> memory(1 << 17);
    UndoLog log;
    log.create(std::as_writable_bytes(std::span(memory)));
    std::vector<std::vector<std::byte>> states{file};
    for (int step = 0; step < 8; ++step) {
      log.begin();
      for (int dab = 0; dab < 5; ++dab) {
        PaintChange change;
        // Materials come and go: channels are taken anew.
        Edit edit = random_dab(random, live.world.info().extent, 4);
        const Status status = edit_paint(live.world, live.span(), edit, &log, change);
        ASSERT_TRUE(status.ok() || std::string(status.field()) == "material") << status.field();
      }
      if (step == 3) {
        Edit wipe;
        wipe.tool = EditTool::paint;
        wipe.material = kNoPaint;
        wipe.radius = 100;
        wipe.hardness = 1;
        PaintChange change;
        ASSERT_TRUE(edit_paint(live.world, live.span(), wipe, &log, change).ok());
        // Another material than those that had channels.
        wipe.material = 5;
        wipe.radius = 2;
        ASSERT_TRUE(edit_paint(live.world, live.span(), wipe, &log, change).ok());
        EXPECT_TRUE(change.materials);
      }
      log.end();
      ASSERT_FALSE(log.is_lost());
      states.push_back(live.save());
    }
    const auto take = [&](UndoPart part) {
      ASSERT_EQ(part.kind(), CellKind::paint);
      PaintChange change;
      exchange_paint(live.world, live.span(), part, change);
      EXPECT_TRUE(change.changed);
    };
    for (std::size_t at = states.size() - 1; at-- > 0;) {
      ASSERT_TRUE(log.undo(take));
      ASSERT_TRUE(live.save() == states[at]) << at;
    }
    for (std::size_t at = 1; at < states.size(); ++at) {
      ASSERT_TRUE(log.redo(take));
      ASSERT_TRUE(live.save() == states[at]) << at;
    }
  }
}

TEST(EditPaint, FailuresChangeNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Painted live(file_of());
  Edit dab;
  dab.tool = EditTool::paint;
  dab.place = {7, 0, 6};
  dab.radius = 2;
  PaintChange change;
  for (std::uint8_t material = 0; material < 4; ++material) {
    dab.material = material;
    dab.place.x = 1 + 4 * material;
    ASSERT_TRUE(edit_paint(live.world, live.span(), dab, nullptr, change).ok());
    EXPECT_TRUE(change.materials);
  }
  const std::vector<std::byte> before = live.save();
  // A fifth has no channel.
  dab.material = 4;
  Status status = edit_paint(live.world, live.span(), dab, nullptr, change);
  EXPECT_EQ(status.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(status.field(), "material");
  dab.material = 1;
  const struct {
    const char* field;
    void (*spoil)(Edit& edit, double nan);
  } spoilt[] = {
      {"material", [](Edit& e, double) { e.material = 6; }},
      {"place", [](Edit& e, double n) { e.place.z = n; }},
      {"place", [](Edit& e, double) { e.place.x = 1e300; }},
      {"to",
       [](Edit& e, double n) {
         e.shape = BrushShape::capsule;
         e.to.y = n;
       }},
      {"half_m",
       [](Edit& e, double) {
         e.shape = BrushShape::box;
         e.half.z = 0;
       }},
      {"radius_m", [](Edit& e, double n) { e.radius = n; }},
      {"radius_m", [](Edit& e, double) { e.radius = 0; }},
      {"amount", [](Edit& e, double n) { e.amount = n; }},
      {"hardness", [](Edit& e, double) { e.hardness = -0.1; }},
      {"shape", [](Edit& e, double) { e.shape = BrushShape::voxel; }},
      {"shape", [](Edit& e, double) { e.shape = static_cast<BrushShape>(60); }},
  };
  for (const auto& [field, spoil] : spoilt) {
    Edit edit = dab;
    spoil(edit, nan);
    status = edit_paint(live.world, live.span(), edit, nullptr, change);
    ASSERT_EQ(status.code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(status.field(), field);
    EXPECT_FALSE(change.changed);
  }
  EXPECT_TRUE(live.save() == before);
  // Where the first has been wiped away the fifth finds room.
  dab.radius = 100;
  dab.hardness = 1;
  dab.material = 4;
  Edit wipe = dab;
  wipe.material = kNoPaint;
  ASSERT_TRUE(edit_paint(live.world, live.span(), wipe, nullptr, change).ok());
  EXPECT_TRUE(edit_paint(live.world, live.span(), dab, nullptr, change).ok());
  // Without memory for it, and without materials.
  Painted none(file_of(), 0, 0);
  status = edit_paint(none.world, none.span(), dab, nullptr, change);
  EXPECT_EQ(status.code(), StatusCode::limit_reached);
  EXPECT_STREQ(status.field(), "paint_width");
}

// Patches with a material of their own keep it.
TEST(EditPaint, OverridesOfBoxesStay) {
  Painted plain(file_of());
  std::vector<std::uint8_t> overrides(plain.world.patch_count(), 0);
  for (std::size_t p = 0; p < overrides.size(); p += 3) overrides[p] = 2;
  Painted live(file_of({}, {}, overrides));
  Edit dab;
  dab.tool = EditTool::paint;
  dab.radius = 100;
  PaintChange change;
  ASSERT_TRUE(edit_paint(live.world, live.span(), dab, nullptr, change).ok());
  EXPECT_TRUE(change.patches);
  for (PatchId p = 0; p < overrides.size(); ++p)
    ASSERT_EQ(live.world.material_overrides()[p], p % 3 == 0 ? 2 : kPaintedByMap);
}

}  // namespace
}  // namespace karst::core
