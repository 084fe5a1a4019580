// SPDX-License-Identifier: MIT
// Edited grounds in files: what is saved is what is live, to the bit, and stays small however often it is
// saved.
#include "tests/library/edit/saved_ground.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <tuple>

#include "terrain/ground/measure_ground.h"
#include "terrain/lod/morph.h"
#include "tests/support/world_io.h"

namespace karst {
namespace {

using test::EditedWorldFile;
using test::FileGround;
using test::Pixels;

constexpr double kWide_m = 6000, kDeep_m = 4800;

std::vector<std::byte> rough_file() {
  static const std::vector<std::byte> file = test::ground_file(test::rough_ground(), test::kRoughSpacing_m);
  return file;
}

Edit hill(const World& world, double x, double z, double strength_m = 40, double radius_m = 150) {
  Edit edit;
  edit.tool = EditTool::extrude;
  edit.shape = BrushShape::cylinder;
  edit.place = world.from_world({x, 0, z});
  edit.radius_m = radius_m;
  edit.strength_m = strength_m;
  return edit;
}

// Of TILE: bytes of tiles that hang from the root from `begin` on, and all of these bytes.
struct Tail {
  std::uint64_t live = 0, all = 0;
};
Tail tail_of(const std::vector<std::byte>& file, std::uint64_t begin) {
  FileGround ground(file);
  Tail tail;
  ground.for_each([&](core::NodeKey, const core::TilePlace& place, const core::Tile&) {
    if (place.offset >= begin) tail.live += place.bytes;
  });
  tail.all = ground.reader.tile_bytes() - begin;
  return tail;
}

std::uint64_t tile_bytes(const std::vector<std::byte>& file) {
  return FileGround(file).reader.tile_bytes();
}

TEST(SaveGround, WhatIsSavedIsWhatIsLive) {
  EditedWorldFile world(rough_file());
  std::mt19937 random(4);
  int changed = 0;
  for (int n = 0; n < 120; ++n) {
    changed += world.apply(test::random_ground_edit(random, *world.host.world, kWide_m, kDeep_m)).changed;
    if (n % 24 != 0) continue;
    const std::vector<std::byte> saved = world.save();
    ASSERT_FALSE(saved == rough_file());
    world.expect_live_tiles(saved, rough_file());
    ASSERT_FALSE(testing::Test::HasFailure()) << n;
    EXPECT_TRUE(world.save() == saved) << "saved twice";
    EditedWorldFile again(saved);
    EXPECT_TRUE(again.save() == saved) << "loaded and saved";
  }
  EXPECT_GT(changed, 80);
}

// The same file by one way or another, and none where nothing is left of edits.
TEST(SaveGround, WhatWasTakenBackIsNotSaved) {
  EditedWorldFile world(rough_file());
  const auto raise = [&](double x, double z) { world.apply(hill(*world.host.world, x, z, 30, 200)); };
  const auto undo = [&] {
    EditResult result;
    ASSERT_TRUE(world.editor->undo(result).ok());
    EXPECT_TRUE(result.changed);
  };
  raise(900, 900);
  const std::vector<std::byte> one = world.save();
  EXPECT_FALSE(one == rough_file());
  raise(4000, 3000);
  EXPECT_FALSE(world.save() == one);
  undo();
  EXPECT_TRUE(world.save() == one);
  undo();
  EXPECT_TRUE(world.save() == rough_file());
}

// Behind the first tiles there is no tile that is not in use, and those stay as they are.
TEST(SaveGround, NothingPilesUp) {
  std::vector<std::byte> file = rough_file();
  const std::uint64_t first = tile_bytes(file);
  std::uint64_t once = 0;
  // The same place again and again.
  for (int n = 0; n < 8; ++n) {
    EditedWorldFile world(file);
    EXPECT_TRUE(world.apply(hill(*world.host.world, 3000, 2400, 3)).changed);
    file = world.save();
    const Tail tail = tail_of(file, first);
    EXPECT_EQ(tail.all, tail.live + 16) << n;
    if (n == 0) once = tail.all;
    EXPECT_LE(tail.all, once + once / 4) << n;
  }
  std::printf("first tiles: %llu bytes; with a hill: %llu more\n", static_cast<unsigned long long>(first),
              static_cast<unsigned long long>(once));
  // All over.
  std::mt19937 random(8);
  std::uint64_t most = 0;
  for (int n = 0; n < 40; ++n) {
    EditedWorldFile world(file);
    for (int edit = 0; edit < 4; ++edit)
      world.apply(test::random_ground_edit(random, *world.host.world, kWide_m, kDeep_m));
    file = world.save();
    const Tail tail = tail_of(file, first);
    ASSERT_EQ(tail.all, tail.live + 16) << n;
    most = std::max(most, tail.all);
    if (n % 20 != 19) continue;
    const std::uint64_t part = static_cast<std::uint64_t>(std::distance(
        file.begin(), std::mismatch(file.begin() + 4096, file.end(), rough_file().begin() + 4096).first));
    EXPECT_GT(part, first / 2) << "first tiles are as they were";
    world.expect_live_tiles(file, world.save());
  }
  std::printf("edited all over in 40 saves: %llu more\n", static_cast<unsigned long long>(most));
  EXPECT_LT(most, 2 * first);
}

// However the place that a file states is wrong, what is saved is right.
TEST(SaveGround, AWrongMarkDoesNoHarm) {
  std::vector<std::byte> file;
  {
    EditedWorldFile world(rough_file());
    world.apply(hill(*world.host.world, 1000, 1000));
    file = world.save();
  }
  FileGround ground(file);
  const std::uint64_t all = ground.reader.tile_bytes();
  const std::uint64_t right = tile_bytes(rough_file());
  std::uint64_t begin = 0;
  const std::span<const std::byte> section = core::section_of(file, "TILE");
  std::byte* const mark = file.data() + (section.data() - file.data()) + section.size() - sizeof begin;
  std::memcpy(&begin, mark, sizeof begin);
  ASSERT_EQ(begin, right);
  for (const std::uint64_t wrong :
       {std::uint64_t{0}, std::uint64_t{1}, right / 2, right + 777, all - 16, all - 15, ~std::uint64_t{0}}) {
    std::memcpy(mark, &wrong, sizeof wrong);
    std::vector<std::byte> marked = file;
    core::fix_checksums(marked);
    EditedWorldFile world(marked);
    world.apply(hill(*world.host.world, 4000, 3000));
    world.expect_live_tiles(world.save(), marked);
    ASSERT_FALSE(testing::Test::HasFailure()) << wrong;
  }
}

// A file that cannot be read, and a sink that takes no more: an error, and the world goes on.
TEST(SaveGround, ErrorsOfFileAndSink) {
  EditedWorldFile world(rough_file());
  world.apply(hill(*world.host.world, 3000, 2400));
  const std::vector<std::byte> saved = world.save();
  std::size_t room = 0;
  const auto save = [&] {
    return world.editor->save({&room, [](void* user, std::span<const std::byte> bytes) {
                                 auto& left = *static_cast<std::size_t*>(user);
                                 if (bytes.size() > left) return false;
                                 left -= bytes.size();
                                 return true;
                               }});
  };
  for (std::size_t bytes = 0; bytes < saved.size(); bytes += saved.size() / 37 + 1) {
    room = bytes;
    const Status status = save();
    EXPECT_EQ(status.code(), StatusCode::limit_reached) << bytes;
    EXPECT_STREQ(status.field(), "sink");
  }
  world.host.file.fails = true;
  room = saved.size();
  EXPECT_EQ(save().code(), StatusCode::io);
  world.host.file.fails = false;
  EXPECT_TRUE(world.save() == saved);
}

// What coarse sizes state holds after each save and load, in which it becomes the file's, too.
TEST(SaveGround, TheStatedErrorHoldsAfterEachEdit) {
  constexpr int kSide = 330;
  constexpr double kSpacing_m = 10;
  const char* const text = std::getenv("KARST_EDITS");
  const int edits = text != nullptr ? std::atoi(text) : 25;
  const test::MemoryGround ground(kSide, kSide, 2048, 2048, test::rough_heights());
  std::vector<std::byte> file = test::ground_file(ground, kSpacing_m);
  std::mt19937 random(12);
  std::size_t nodes = 0;
  double most_share = 0, loose = 0;
  for (int n = 0; n < edits; ++n) {
    loose = 0;
    const std::vector<std::byte> before = file;
    {
      EditedWorldFile world(file, 150);
      world.apply(
          test::random_ground_edit(random, *world.host.world, kSide * kSpacing_m, kSide * kSpacing_m));
      file = world.save();
      world.expect_live_tiles(file, before);
      ASSERT_FALSE(HasFailure()) << n;
    }
    FileGround saved(file);
    std::vector<std::int32_t> samples(std::size_t{kSide} * kSide);
    std::map<std::tuple<int, int, int>, core::Tile> coarse;
    saved.for_each([&](core::NodeKey key, const core::TilePlace&, const core::Tile& tile) {
      if (key.size > core::kReferenceSizes) coarse[{key.size, key.x, key.z}] = tile;
      if (key.size > 0) return;
      for (int k = 0; k <= core::kTileQuads && key.z * core::kTileQuads + k < kSide; ++k) {
        for (int i = 0; i <= core::kTileQuads && key.x * core::kTileQuads + i < kSide; ++i)
          samples[static_cast<std::size_t>((key.z * core::kTileQuads + k) * kSide + key.x * core::kTileQuads +
                                           i)] = tile.height(i, k);
      }
    });
    const core::GroundInfo& info = saved.reader.ground();
    const test::MemoryGround made(kSide, kSide, 2048, 2048, [&](std::int64_t i, std::int64_t k) {
      return samples[static_cast<std::size_t>(k * kSide + i)];
    });
    const auto at = [&](std::int64_t i, std::int64_t k) {
      return double{core::kVertexStep} *
             samples[static_cast<std::size_t>(std::min<std::int64_t>(k, kSide - 1) * kSide +
                                              std::min<std::int64_t>(i, kSide - 1))];
    };
    for (const auto& [key, tile] : coarse) {
      const auto [size, tx, tz] = key;
      for (int node = 0; node < core::kTileMeasures; ++node) {
        const core::NodeKey own{size, tx * core::kTileNodes + node % core::kTileNodes,
                                tz * core::kTileNodes + node / core::kTileNodes};
        if (!core::node_exists(info, own)) continue;
        const auto& anew = made.tile(core::tile_of(own)).nodes[node];
        EXPECT_EQ(tile.nodes[node].low, anew.low);
        EXPECT_EQ(tile.nodes[node].high, anew.high);
        const double most = test::most_off_node(own, kSide, kSide, at);
        ++nodes;
        for (int d = 0; d < core::kDemands; ++d) {
          const double stated = double{core::threshold_steps(tile.nodes[node].thresholds[d])} *
                                std::ldexp(1.0, info.page_size(size));
          ASSERT_GE(stated, core::demand(d) * most) << n << ": " << size << " " << own.x << " " << own.z;
          most_share = std::max(most_share, core::demand(d) * most / stated);
          ASSERT_GE(tile.nodes[node].thresholds[d], anew.thresholds[d]) << n;
          loose = std::max(loose, double{core::threshold_steps(tile.nodes[node].thresholds[d])} /
                                      double{core::threshold_steps(anew.thresholds[d])});
        }
      }
    }
  }
  EXPECT_GT(nodes, static_cast<std::size_t>(edits));
  std::printf(
      "%zu nodes of sizes above %d: at most %.3f of what is stated, which is %.1f times what baking states\n",
      nodes, core::kReferenceSizes, most_share, loose);
}

class SaveGroundPictures : public test::HostTest {
 protected:
  static constexpr int kWidth = 160, kHeight = 120;
  SaveGroundPictures() : HostTest(kWidth, kHeight) {}

  void open_file(const std::vector<std::byte>& file) {
    Needs needs;
    needs.queries = 1;
    needs.edit_tiles = 100;
    needs.shadow_maps = 2;
    open(needs, {}, {}, file);
  }
  std::vector<Pixels> pictures() {
    std::vector<Pixels> all;
    const Vec3 eyes[] = {{2900, 420, 2520}, {2500, 150, 2100}, {300, 2500, 300}};
    for (const Vec3& eye : eyes) {
      ViewState view = test::looking(*host_->world, eye, {3000, 60, 2400}, kWidth, kHeight);
      view.error_px = 1;
      test::draw_frame(*renderer_, picture_, {view});
      all.push_back(picture_.read());
    }
    return all;
  }
  std::vector<double> answers() {
    Query* query = nullptr;
    EXPECT_TRUE(host_->world->take_query(query).ok());
    std::vector<double> all;
    std::mt19937 random(3);
    for (int n = 0; n < 400; ++n) {
      const Vec3 at{std::uniform_real_distribution<double>(2400, 3600)(random), 1000,
                    std::uniform_real_distribution<double>(1900, 2900)(random)};
      Hit hit;
      EXPECT_TRUE(query->ground(host_->world->from_world(at), 0, Wait::for_file, hit));
      all.insert(all.end(), {hit.place.x, hit.place.y, hit.place.z, hit.normal.x, hit.normal.y});
    }
    host_->world->release(query);
    return all;
  }
  std::vector<std::byte> edit_and_save() {
    Editor* editor = nullptr;
    EXPECT_TRUE(host_->world->take_editor(editor).ok());
    EditResult result;
    EXPECT_TRUE(editor->apply(hill(*host_->world, 3000, 2400, 80), result).ok());
    Edit noise = hill(*host_->world, 3150, 2300, 12, 300);
    noise.tool = EditTool::noise;
    noise.wave_m = 80;
    EXPECT_TRUE(editor->apply(noise, result).ok());
    std::vector<std::byte> out;
    EXPECT_TRUE(editor
                    ->save({&out,
                            [](void* user, std::span<const std::byte> bytes) {
                              auto& to = *static_cast<std::vector<std::byte>*>(user);
                              to.insert(to.end(), bytes.begin(), bytes.end());
                              return true;
                            }})
                    .ok());
    host_->world->release(editor);
    return out;
  }
};

// With images over it and water in it, which stay.
TEST_F(SaveGroundPictures, TheSavedWorldIsDrawnAndAnswersAsTheLiveOne) {
  core::WorldMaterials materials;
  materials.surroundings.flags = 1;
  materials.surroundings.water_level = 8;
  const test::GroundImages images{
      [](double column, double row) {
        const bool even = (static_cast<int>(column / 9) + static_cast<int>(row / 9)) % 2 == 0;
        return std::array<std::uint8_t, 4>{even ? std::uint8_t{200} : std::uint8_t{40}, 120, 60, 255};
      },
      3};
  for (const bool rich : {false, true}) {
    const std::vector<std::byte> file =
        rich ? test::ground_file(test::rough_ground(), test::kRoughSpacing_m, images, materials)
             : rough_file();
    open_file(file);
    const std::vector<Pixels> intact = pictures();
    const std::vector<std::byte> saved = edit_and_save();
    const std::vector<Pixels> live = pictures();
    const std::vector<double> asked = answers();
    close();
    EXPECT_GT(test::share_beyond(intact[0], live[0], 8), 0.02);
    open_file(saved);
    EXPECT_TRUE(answers() == asked);
    const std::vector<Pixels> loaded = pictures();
    for (std::size_t n = 0; n < live.size(); ++n)
      EXPECT_EQ(test::largest_difference(live[n], loaded[n]), 0) << n << (rich ? ", with images" : "");
    close();
    for (const char* const kind : {"IMAG", "SURR", "MATL"}) {
      const auto own = core::section_of(std::span<const std::byte>(saved), kind);
      const auto before = core::section_of(std::span<const std::byte>(file), kind);
      EXPECT_TRUE(std::equal(own.begin(), own.end(), before.begin(), before.end())) << kind;
      EXPECT_EQ(rich && std::strcmp(kind, "MATL") != 0, !before.empty()) << kind;
    }
  }
}

}  // namespace
}  // namespace karst
