// SPDX-License-Identifier: MIT
#include "tests/library/edit/saved_ground.h"

#include <cstring>
#include <string_view>

#include "scene/world/tile_reader.h"

namespace karst::test {

using core::ByteSource;
using core::EditedTile;
using core::GroundOverlay;
using core::NodeKey;
using core::Tile;
using core::TilePlace;
using core::TileReader;

FileGround::FileGround(std::vector<std::byte> file) : bytes(std::move(file)) {
  const Status opened = reader.open(ByteSource::of(bytes));
  EXPECT_TRUE(opened.ok()) << opened.what() << " " << opened.field();
  const Status whole = reader.verify();
  EXPECT_TRUE(whole.ok()) << whole.what() << " " << whole.field();
}

void FileGround::for_each(const std::function<void(NodeKey, const TilePlace&, const Tile&)>& visit) {
  std::vector<std::uint64_t> room((TileReader::workspace_bytes() + 7) / 8);
  const std::function<void(NodeKey, TilePlace)> walk = [&](NodeKey key, TilePlace place) {
    const auto tile = std::make_unique<Tile>();
    const Status status =
        TileReader::read(reader, key, place, std::as_writable_bytes(std::span(room)), *tile);
    ASSERT_TRUE(status.ok()) << status.what() << " " << key.size << " " << key.x << " " << key.z;
    visit(key, place, *tile);
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      if (tile->children[quadrant].exists()) walk(key.child(quadrant), tile->children[quadrant]);
    }
  };
  walk(core::tile_of({reader.ground().top_size(), 0, 0}), reader.root_tile());
}

namespace {

Needs needs_of(std::uint32_t tiles) {
  Needs needs;
  needs.queries = 1;
  needs.edit_tiles = tiles;
  needs.undo_bytes = 1 << 20;
  needs.shadow_maps = 0;
  return needs;
}

}  // namespace

EditedWorldFile::EditedWorldFile(std::vector<std::byte> file, std::uint32_t tiles)
    : host(needs_of(tiles), {.axes = Axes::east_up_south}, std::move(file)) {
  EXPECT_TRUE(host.world->take_editor(editor).ok());
}

EditedWorldFile::~EditedWorldFile() {
  host.world->release(editor);
}

EditResult EditedWorldFile::apply(const karst::Edit& edit) {
  EditResult result;
  const Status status = editor->apply(edit, result);
  // Random ones may be too steep.
  EXPECT_TRUE(status.ok() || std::string_view(status.field()) == "strength_m")
      << status.what() << " " << status.field();
  return result;
}

std::vector<std::byte> EditedWorldFile::save() {
  std::vector<std::byte> out;
  const Sink sink{&out, [](void* user, std::span<const std::byte> bytes) {
                    auto& to = *static_cast<std::vector<std::byte>*>(user);
                    to.insert(to.end(), bytes.begin(), bytes.end());
                    return true;
                  }};
  const Status status = editor->save(sink);
  EXPECT_TRUE(status.ok()) << status.what() << " " << status.field();
  return out;
}

void expect_live_tiles(const core::WorldObject& world, const std::vector<std::byte>& saved,
                       const std::vector<std::byte>& original) {
  const GroundOverlay& overlay = world.ground_edits->overlay();
  FileGround now(saved), before(original);
  EXPECT_EQ(now.reader.ground().low, world.ground_edits->info().low);
  EXPECT_EQ(now.reader.ground().high, world.ground_edits->info().high);
  std::vector<Tile> tiles, files;
  std::vector<NodeKey> keys;
  before.for_each([&](NodeKey key, const TilePlace&, const Tile& tile) {
    const EditedTile* const edited = overlay.find(key);
    tiles.push_back(edited != nullptr ? edited->tile : tile);
    keys.push_back(key);
  });
  std::size_t n = 0;
  now.for_each([&](NodeKey key, const TilePlace&, const Tile& tile) {
    ASSERT_LT(n, tiles.size());
    ASSERT_TRUE(key == keys[n]);
    ASSERT_EQ(std::memcmp(tile.heights, tiles[n].heights, sizeof tile.heights), 0)
        << key.size << " " << key.x << " " << key.z;
    ASSERT_EQ(std::memcmp(tile.nodes, tiles[n].nodes, sizeof tile.nodes), 0)
        << key.size << " " << key.x << " " << key.z;
    ++n;
  });
  EXPECT_EQ(n, tiles.size());
}

karst::Edit random_ground_edit(std::mt19937& random, const karst::World& world, double wide_m,
                               double deep_m) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  constexpr karst::EditTool kTools[] = {karst::EditTool::extrude, karst::EditTool::smooth,
                                        karst::EditTool::noise, karst::EditTool::flatten,
                                        karst::EditTool::level};
  constexpr karst::BrushShape kShapes[] = {karst::BrushShape::sphere, karst::BrushShape::cylinder,
                                           karst::BrushShape::box, karst::BrushShape::capsule};
  karst::Edit edit;
  edit.tool = kTools[random() % 5];
  edit.shape = kShapes[random() % 4];
  const Vec3 at{between(-20, wide_m + 20), between(0, 60), between(-20, deep_m + 20)};
  edit.place = world.from_world(at);
  edit.to = world.from_world({at.x + between(-90, 90), at.y, at.z + between(-90, 90)});
  edit.half_m = {between(10, 90), 40, between(10, 90)};
  edit.up = {between(-0.3, 0.3), 1, between(-0.3, 0.3)};
  edit.radius_m = between(10, 140);
  edit.strength_m = between(-20, 20);
  edit.amount = between(0, 1);
  edit.hardness = between(0, 1);
  edit.wave_m = between(20, 200);
  edit.seed = static_cast<std::uint32_t>(random());
  return edit;
}

}  // namespace karst::test
