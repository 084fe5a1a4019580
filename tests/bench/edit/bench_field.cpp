// SPDX-License-Identifier: MIT
// Dabs of radius 4 cells in a field of 128^3 samples, from the call to the bytes of all meshes that are to be
// uploaded: the edit with what its step keeps, the choice of blocks, their meshes as vertices and indices.
// And queries of the same field.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <vector>

#include "terrain/blocks/isosurface.h"
#include "terrain/edit/field/edit_field.h"
#include "terrain/edit/undo_log.h"
#include "terrain/query/query.h"
#include "tests/bench/bench.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr int kBlocks = 8;
constexpr double kSide = 16.0 * kBlocks;

// Hills over caves.
double shape_at(const glm::dvec3& p) {
  const double hill = p.y - 0.6 * kSide - 6 * std::sin(0.11 * p.x) * std::cos(0.13 * p.z);
  const double cave = std::sin(0.2 * p.x) * std::cos(0.2 * p.y) + std::sin(0.2 * p.y) * std::cos(0.2 * p.z) +
                      std::sin(0.2 * p.z) * std::cos(0.2 * p.x);
  return std::max(hill, 3.3 * (cave - 0.6));
}

struct Scene {
  Scene() : memory(bytes_of(config())), arena(memory.bytes()) {
    FieldBlocks::Storage storage;
    storage.each_block(config(), TakeBlocks(arena));
    field.create(storage);
  }
  static Config config() {
    Config config;
    config.field_blocks = config.field_sample_blocks = kBlocks * kBlocks * kBlocks;
    config.field_meshes = 2'048;
    config.field_vertex_pages = config.field_index_pages = 20'000;
    return config;
  }
  static std::size_t bytes_of(const Config& config) {
    Budget budget;
    FieldBlocks::Storage storage;
    storage.each_block(config, CountBlocks(budget));
    Isosurface::add_to(budget, config);
    return budget.cpu_bytes();
  }
  bool fill() {
    FieldInfo info;
    info.blocks = glm::ivec3(kBlocks);
    info.stored = config().field_sample_blocks;
    if (!field.reset(info).ok() || !isosurface.create(config(), arena).ok()) return false;
    for (int b = 0; b < kBlocks * kBlocks * kBlocks; ++b) {
      const glm::ivec3 block(b % kBlocks, b / kBlocks % kBlocks, b / kBlocks / kBlocks);
      const std::span<std::int8_t> out = field.bytes().open(block);
      for (int n = 0; n < static_cast<int>(out.size()); ++n) {
        const glm::dvec3 p(block * 16 + glm::ivec3(n & 15, n >> 4 & 15, n >> 8));
        out[static_cast<std::size_t>(n)] =
            static_cast<std::int8_t>(std::clamp(std::floor(64 * shape_at(p)), -128.0, 127.0));
      }
      field.bytes().close(block);
    }
    isosurface.attach(field);
    return true;
  }
  // Bytes of vertices and indices of the meshes that a frame near a place lacks.
  std::size_t make(const glm::dvec3& eye_cells, std::size_t& meshes) {
    BlockEye eye;
    eye.eye.eye = glm::vec3(eye_cells * double{kStepsPerVoxel});
    eye.eye.least_cos2 = 0.4f;
    eye.eye.forward = glm::vec3(0, 0, -1);
    eye.steps_per_step = 400;
    isosurface.begin_frame();
    isosurface.choose(std::span(&eye, 1));
    MeshUpload upload;
    Status status;
    std::size_t bytes = 0;
    while (isosurface.make_next(upload, status)) {
      // As a renderer takes them.
      std::memcpy(staging.data(), upload.vertices.data(), upload.vertices.size_bytes());
      bytes += upload.vertices.size_bytes();
      ++meshes;
    }
    return bytes;
  }

  test::AlignedBytes memory;
  Arena arena;
  FieldBlocks field;
  Isosurface isosurface;
  std::vector<GpuVertex> staging = std::vector<GpuVertex>(65'536);
};

double at_share(std::vector<double> times, double share) {
  std::ranges::sort(times);
  return 1e3 * times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
}

int run_field(bool smoke) {
  Scene scene;
  if (!scene.fill()) return 1;
  std::vector<std::uint64_t> memory(std::size_t{4} << 17);
  UndoLog log;
  log.create(std::as_writable_bytes(std::span(memory)));
  std::vector<std::uint32_t> kept_in(kBlocks * kBlocks * kBlocks);
  std::size_t meshes = 0;
  for (int n = 0; n < 4; ++n) scene.make({64, 80, 64}, meshes);
  int result = meshes > 0 ? 0 : 1;
  const int repeats = smoke ? 3 : 201;
  struct Tool {
    const char* name;
    EditTool tool;
  };
  for (const Tool& tool : {Tool{"clear", EditTool::clear}, Tool{"fill", EditTool::fill},
                           Tool{"flatten", EditTool::flatten}, Tool{"smooth", EditTool::smooth}}) {
    std::vector<double> edits, all, undone;
    std::size_t bytes = 0, changed = 0;
    meshes = 0;
    test::Random random{11};
    for (int n = 0; n < repeats; ++n) {
      Edit edit;
      edit.tool = tool.tool;
      edit.place = {20 + 88 * random.unit(), 0, 20 + 88 * random.unit()};
      edit.place.y = 0.6 * kSide + 6 * std::sin(0.11 * edit.place.x) * std::cos(0.13 * edit.place.z);
      edit.radius = 4;
      edit.amount = 0.5;
      FieldChange change;
      const double start = bench::cpu_ms();
      log.begin();
      if (!edit_field({&scene.field, kept_in}, edit, &log, change).ok()) return 1;
      log.end();
      const double middle = bench::cpu_ms();
      if (change.changed) scene.isosurface.change(change.first, change.last);
      bytes += scene.make(edit.place + glm::dvec3(0, 10, 0), meshes);
      const double end = bench::cpu_ms();
      edits.push_back(middle - start);
      all.push_back(end - start);
      changed += change.changed;
      if (!scene.isosurface.is_complete()) result = 1;
      // The next one finds all as it was.
      const double back = bench::cpu_ms();
      if (change.changed) {
        log.undo([&](UndoPart part) { exchange_field(scene.field, part, change); });
        undone.push_back(bench::cpu_ms() - back);
        scene.isosurface.change(change.first, change.last);
      }
      std::size_t others = 0;
      for (int k = 0; k < 3; ++k) scene.make(edit.place + glm::dvec3(0, 10, 0), others);
    }
    if (changed == 0) return 1;
    std::printf(
        "  %-7s microseconds: edit %.0f, to the bytes of %.1f meshes (%.0f KiB) %.0f (median), %.0f (9 of "
        "10); "
        "taken back %.0f\n",
        tool.name, at_share(edits, 0.5), static_cast<double>(meshes) / repeats,
        static_cast<double>(bytes) / repeats / 1024, at_share(all, 0.5), at_share(all, 0.9),
        at_share(undone, 0.5));
  }
  return result;
}

// Rays as long as the field is wide, and straight down.
int run_field_queries(bool smoke) {
  Scene scene;
  if (!scene.fill()) return 1;
  Query::Limits limits;
  Budget budget;
  Query::add_to(budget, limits);
  test::AlignedBytes memory(budget.cpu_bytes());
  Arena arena(memory.bytes());
  Query query;
  const BoundsTree tree;
  QueryWorld world;
  world.tree = &tree;
  world.heights.level = 1;
  if (!query.create(limits, arena).ok() || !query.set_world(world).ok()) return 1;
  query.set_field(&scene.field);
  test::Random random{5};
  const int count = smoke ? 100 : 20'000;
  int met = 0, on_ground = 0;
  const auto any = [&] { return kSide * glm::dvec3(random.unit(), random.unit(), random.unit()); };
  QueryHit hit;
  const double start = bench::cpu_ms();
  for (int n = 0; n < count; ++n) met += query.ray(any(), any(), Wait::never, hit);
  const double middle = bench::cpu_ms();
  for (int n = 0; n < count; ++n) {
    glm::dvec3 at = any();
    at.y = kSide;
    on_ground += query.ground(at, 0, Wait::never, hit);
  }
  const double end = bench::cpu_ms();
  std::printf("  rays %.2f us each, %d of %d met; ground %.2f us each, %d of %d found\n",
              1e3 * (middle - start) / count, met, count, 1e3 * (end - middle) / count, on_ground, count);
  return met > 0 && on_ground > 0 ? 0 : 1;
}

const bench::Register kRegister{{"field", run_field}}, kQueries{{"field_queries", run_field_queries}};

}  // namespace
}  // namespace karst::core
