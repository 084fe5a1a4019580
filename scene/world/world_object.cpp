// SPDX-License-Identifier: MIT
#include "scene/world/world_object.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <new>

#include "karst/karst.h"
#include "terrain/base/check.h"

namespace karst {
namespace core {
namespace {

constexpr std::size_t whole_lines(std::size_t bytes) {
  return (bytes + kMemoryAlignment - 1) / kMemoryAlignment * kMemoryAlignment;
}

WorldObject& self(karst::World* world) {
  return *static_cast<WorldObject*>(world);
}
const WorldObject& self(const karst::World* world) {
  return *static_cast<const WorldObject*>(world);
}

// Hands out pieces of memory from the front.
class Pieces {
 public:
  explicit Pieces(std::span<std::byte> memory) : left_(memory) {}
  std::span<std::byte> take(std::size_t bytes) {
    KARST_ASSERT(bytes <= left_.size());
    const std::span<std::byte> piece = left_.first(bytes);
    left_ = left_.subspan(bytes);
    return piece;
  }

 private:
  std::span<std::byte> left_;
};

QueryWorld query_world(const World& world) {
  QueryWorld out;
  out.surface = world.surface();
  out.bounds = world.bounds();
  out.tree = &world.tree();
  out.corner = world.parts()[0].corner;
  out.heights.level = world.info().level;
  if (world.holds_all_heights()) out.heights = world.heights();
  out.height_blocks = world.info().height_blocks;
  out.source = world.height_source();
  return out;
}

// The host's function in the core's words. ground: outlives the reader.
Status lend_function(const GroundFunction& ground, WorldReader& reader) {
  if (ground.place == nullptr || ground.up == nullptr)
    return {StatusCode::invalid_argument, "the function that says where this ground lies is missing",
            "ground"};
  BasisFunction function;
  function.context = &ground;
  function.place = [](const void* of, double u, double v, double height_m) {
    const auto& host = *static_cast<const GroundFunction*>(of);
    return to_glm(host.place(host.user, u, v, height_m));
  };
  function.up = [](const void* of, double u, double v) {
    const auto& host = *static_cast<const GroundFunction*>(of);
    return to_glm(host.up(host.user, u, v));
  };
  if (ground.inverse != nullptr) {
    function.inverse = [](const void* of, glm::dvec3 place_m, double& u, double& v, double& height_m) {
      const auto& host = *static_cast<const GroundFunction*>(of);
      return host.inverse(host.user, from_glm(place_m), u, v, height_m);
    };
  }
  return reader.lend(function);
}

}  // namespace

std::size_t objects_bytes(std::uint32_t queries) {
  return whole_lines(sizeof(WorldObject)) + whole_lines(renderer_object_bytes()) +
         whole_lines(queries * sizeof(QueryObject));
}

Status WorldObject::load(const Plan& plan, const Source& source, std::span<std::byte> memory, Log lines) {
  made_for = plan;
  file = source;
  log = lines;
  WorldReader reader;
  const Status other{StatusCode::invalid_argument, "not made for this file", "plan"};
  if (!read_from(plan.head, reader)) return other;
  if (const Status status = reader.go_on(byte_source(file)); !status.ok())
    return status.code() == StatusCode::invalid_argument ? other : status;
  if (reader.ground().basis.kind == BasisKind::function) {
    if (const Status status = lend_function(made_for.ground, reader); !status.ok()) return status;
  }
  const WorldInfo& info = reader.info();
  if (const Status status = lay_out(PlannedWorld::of(reader), plan.needs, layout); !status.ok())
    return status;
  if (layout.cpu_bytes() != plan.cpu_bytes || layout.budget.gpu_bytes() != plan.gpu_bytes) {
    return {StatusCode::invalid_argument, "changed since make_plan()", "plan", layout.cpu_bytes()};
  }
  const int bits = reader.ground().basis.is_curved() ? kFinestCameraFractionBits : kCameraFractionBits;
  const WorldFrame frame{{info.origin_m[0], info.origin_m[1], info.origin_m[2]}, info.voxel_size_m};
  if (const Status status = placement.create(plan.placement, frame, bits); !status.ok()) return status;

  Pieces pieces(memory);
  pieces.take(whole_lines(sizeof(WorldObject)));  // this
  renderer_room = pieces.take(whole_lines(renderer_object_bytes()));
  const std::span<std::byte> objects = pieces.take(whole_lines(plan.needs.queries * sizeof(QueryObject)));
  staging = pieces.take(layout.staging_bytes);
  if (const Status status = terrain.create(layout.config, pieces.take(layout.terrain_bytes)); !status.ok())
    return status;
  if (const Status status = terrain.load(reader); !status.ok()) return status;
  const core::World& world = terrain.world;
  if (world.patch_count() == 0 && !world.ground().exists() && !world.field().exists())
    return {StatusCode::corrupt, "the world has no surface", "patches"};
  if (world.ground().exists()) {
    const std::span<std::byte> reading = pieces.take(layout.reading_bytes);
    if (const Status status = open_ground(reading, pieces.take(layout.edit_bytes)); !status.ok())
      return status;
  }

  editor.log.create(pieces.take(layout.undo_bytes));

  shown = public_info(world.reader());
  show_box();

  auto* const first = reinterpret_cast<QueryObject*>(objects.data());
  for (std::uint32_t n = 0; n < plan.needs.queries; ++n) {
    auto* const query = new (first + n) QueryObject;
    queries = {first, n + 1};
    Status status = query->create(layout.query_limits, placement, pieces.take(layout.query_bytes));
    if (status.ok()) status = show_world(*query);
    if (!status.ok()) return status;
  }
  return {};
}

Status WorldObject::show_world(QueryObject& query) const {
  const core::World& world = terrain.world;
  query.octree_depth = shown.octree_depth;
  const Status status = query.show(query_world(world), world.parts());
  if (status.ok() && world.field().exists()) query.asked.set_field(&world.field(), world.field_corner());
  if (status.ok() && world.ground().exists())
    query.asked.set_ground(world.ground(), &terrain.ground.root_tile(), ground_reading());
  return status;
}

void WorldObject::show_box() {
  const core::World& world = terrain.world;
  // An edit may have taken all there was.
  if (world.free_patches() == world.patch_count() && !world.ground().exists() && !world.field().exists())
    return;
  const WorldFrame& frame = placement.world();
  const auto metres = [&](glm::ivec3 lattice) {
    return from_glm(frame.origin_m +
                    glm::dvec3(lattice) / static_cast<double>(kStepsPerVoxel) * frame.voxel_size_m);
  };
  shown.low_m = metres(world.box().min);
  shown.high_m = metres(world.box().max);
}

Status WorldObject::open_ground(std::span<std::byte> memory, std::span<std::byte> edits) {
  const WorldReader& reader = terrain.world.reader();
  // The root's, through the same memory.
  const NodeKey root = tile_of({reader.ground().top_size(), 0, 0});
  auto* const tile = new (memory.data()) Tile;
  const Status status =
      TileReader::read(reader, root, reader.root_tile(), memory.subspan(whole_lines(sizeof(Tile))), *tile);
  if (!status.ok()) return status;
  TileSource source = tiles.source();
  if (!edits.empty()) {
    ground_edits = new (edits.data()) EditGround;
    Arena arena(edits.subspan(whole_lines(sizeof(EditGround))));
    if (const Status created = ground_edits->create(layout.edit_limits, arena); !created.ok()) return created;
    source = ground_edits->overlay().source();
  }
  terrain.ground.attach(terrain.world.ground(), *tile, source);
  if (reader.imagery().exists() && layout.config.image_layers > 0)
    terrain.imagery.attach(reader.ground(), reader.imagery(), reader.root_image(), tiles.image_source());
  tiles.start(reader, memory);
  if (ground_edits != nullptr) {
    ground_edits->attach(terrain.world.ground(), terrain.ground.root_tile(), tiles.source(), tiles.reading());
  }
  if (!tiles.has_thread()) say(Severity::warning, "tiles are read by frames: no thread could be made");
  return {};
}

}  // namespace core

Status World::create(const Plan& plan, const Source& file, std::span<std::byte> memory, World*& out,
                     Log log) noexcept {
  out = nullptr;
  if (plan.cpu_bytes < sizeof(core::WorldObject)) {
    return {StatusCode::invalid_argument, "not made by make_plan()", "plan"};
  }
  if (memory.size() < plan.cpu_bytes) {
    return {StatusCode::limit_reached, "the memory given is smaller than the plan", "memory", plan.cpu_bytes};
  }
  if (reinterpret_cast<std::uintptr_t>(memory.data()) % kMemoryAlignment != 0) {
    return {StatusCode::invalid_argument, "the memory given is not aligned to 64 bytes", "memory"};
  }
  auto* const world = new (memory.data()) core::WorldObject;
  const Status status = world->load(plan, file, memory.first(plan.cpu_bytes), log);
  if (status.ok()) {
    out = world;
  } else {
    world->destroy();
  }
  return status;
}

void World::destroy() noexcept {
  core::WorldObject& world = core::self(this);
  KARST_ASSERT(!world.has_renderer);
  for (core::QueryObject& query : world.queries) query.~QueryObject();
  world.~WorldObject();
}

const WorldInfo& World::info() const noexcept {
  return core::self(this).shown;
}

const Plan& World::plan() const noexcept {
  return core::self(this).made_for;
}

Status World::take_query(Query*& out) noexcept {
  out = nullptr;
  for (core::QueryObject& query : core::self(this).queries) {
    if (query.taken.exchange(true)) continue;
    out = &query;
    return {};
  }
  return {StatusCode::limit_reached, "all queries of the plan are taken", "queries",
          core::self(this).queries.size() + 1};
}

void World::release(Query* query) noexcept {
  if (query != nullptr) static_cast<core::QueryObject*>(query)->taken.store(false);
}

Status World::take_editor(Editor*& out) noexcept {
  out = nullptr;
  core::WorldObject& world = core::self(this);
  const Needs& needs = world.made_for.needs;
  const bool sculpts = (needs.field_sample_blocks > 0 || needs.field_material_blocks > 0) &&
                       world.terrain.world.field().exists();
  if (needs.edit_patches == 0 && needs.edit_tiles == 0 && needs.paint_width == 0 && !sculpts)
    return {StatusCode::invalid_argument, "the plan has no room for edits", "edit_patches"};
  if (world.editor.taken.exchange(true))
    return {StatusCode::limit_reached, "the world's one editor is taken", "editors", 2};
  out = &world.editor;
  return {};
}

void World::release(Editor* editor) noexcept {
  if (editor == nullptr) return;
  auto& object = *static_cast<core::EditorObject*>(editor);
  object.end_stroke();
  object.taken.store(false);
}

Vec3 World::to_world(Vec3 place) const noexcept {
  return core::from_glm(core::self(this).placement.world_m(place));
}

Vec3 World::from_world(Vec3 place_m) const noexcept {
  return core::self(this).placement.place(core::to_glm(place_m));
}

namespace core {
namespace {

const WorldReader& reader_of(const karst::World* world) {
  return self(world).terrain.world.reader();
}

}  // namespace
}  // namespace core

bool World::to_geodetic(Vec3 place, Geodetic& out) const noexcept {
  const core::WorldReader& reader = core::reader_of(this);
  core::Geodetic geodetic;
  if (!core::to_geodetic(reader.ground().basis, reader.earth(), core::self(this).placement.world_m(place),
                         geodetic))
    return false;
  out = {geodetic.longitude_deg, geodetic.latitude_deg, geodetic.altitude_m};
  return true;
}

bool World::from_geodetic(const Geodetic& geodetic, Vec3& place) const noexcept {
  const core::WorldReader& reader = core::reader_of(this);
  glm::dvec3 world_m;
  const core::Geodetic at{geodetic.longitude_deg, geodetic.latitude_deg, geodetic.altitude_m};
  if (!core::from_geodetic(reader.ground().basis, reader.earth(), at, world_m)) return false;
  place = core::self(this).placement.place(world_m);
  return true;
}

bool World::to_projected(Vec3 place, Projected& out) const noexcept {
  const core::WorldReader& reader = core::reader_of(this);
  glm::dvec3 at;
  if (!core::to_projected(reader.ground().basis, reader.earth(), core::self(this).placement.world_m(place),
                          at))
    return false;
  out = {at.x, at.y, at.z};
  return true;
}

bool World::from_projected(const Projected& projected, Vec3& place) const noexcept {
  const core::WorldReader& reader = core::reader_of(this);
  glm::dvec3 world_m;
  if (!core::from_projected(reader.ground().basis, reader.earth(),
                            {projected.east, projected.north, projected.height_m}, world_m))
    return false;
  place = core::self(this).placement.place(world_m);
  return true;
}

LocalAxes World::axes_at(Vec3 place) const noexcept {
  const core::PlacementFrame& placement = core::self(this).placement;
  const glm::dmat3 axes = core::axes_of(core::reader_of(this).ground().basis, placement.world_m(place));
  return {placement.direction(axes[0]), placement.direction(axes[1]), placement.direction(-axes[2])};
}

std::uint32_t api_version() noexcept {
  return kApiVersion;
}

}  // namespace karst
