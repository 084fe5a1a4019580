// SPDX-License-Identifier: MIT
// Prints one line "stage hash" for each CPU stage on a fixed world: the same on every compiler, build type
// and instruction set. ./dev test compares gcc and clang, debug and release.
#include <bit>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <vector>

#include "terrain/base/checksum.h"
#include "terrain/draw/index_batches.h"
#include "terrain/patch/fit_heights.h"
#include "terrain/view/camera.h"
#include "terrain/world/terrain_parts.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

template <class T>
void print(const char* stage, std::span<const T> values) {
  std::printf("%s %08x\n", stage, crc32c(std::as_bytes(values)));
}

// A landscape with overhangs, from integer hashes and + - * / alone.
double density(glm::dvec3 p) {
  const double ground = 9 + 4 * test::value_noise(21, glm::dvec3(p.x, 0, p.z) / 11.0);
  return ground - p.y + 3 * test::value_noise(22, p / 5.0) + 0.15 * test::value_noise(23, p * 2.0);
}

// Everything but padding bytes, which these do not have.
static_assert(sizeof(Volume) == 32 && sizeof(Patch) == 28);

// Volumes with the number of their first patch, so that the hash tells that patches follow one another.
std::vector<std::uint8_t> numbered(std::span<const Volume> volumes) {
  std::vector<std::uint8_t> bytes;
  const auto put = [&](const void* from, std::size_t count) {
    const auto* first = static_cast<const std::uint8_t*>(from);
    bytes.insert(bytes.end(), first, first + count);
  };
  std::uint32_t patch = 0;
  for (const Volume& v : volumes) {
    put(&v, offsetof(Volume, gradient));
    put(&patch, sizeof patch);
    put(v.gradient, sizeof v.gradient);
    patch += v.patch_count;
  }
  return bytes;
}

bool run() {
  const glm::ivec3 extent(30, 20, 30);
  test::TestWorld world(extent, [](glm::ivec3 v) { return density(glm::dvec3(v) + 0.5) > 0; });
  std::vector<std::uint8_t> voxels;
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      for (int x = 0; x < extent.x; ++x) voxels.push_back(world.octree().filled({x, y, z}) ? 1 : 0);
    }
  }
  print("voxels", std::span<const std::uint8_t>(voxels));
  const std::vector<std::uint8_t> volumes = numbered(world.surface().volumes);
  print("volumes", std::span<const std::uint8_t>(volumes));
  print("patches", world.surface().patches);

  constexpr int kLevel = 4;
  std::vector<std::int16_t> heights(world.patches().size() *
                                    static_cast<std::size_t>(patch_vertices(kLevel)));
  FitHeights fit;
  fit.surface = world.surface();
  fit.field.value = [](const void*, glm::dvec3 p) { return density(p); };
  fit.level = kLevel;
  fit.heights = heights;
  FitHeights::Result fitted;
  if (!fit.validate().ok()) return false;
  fit.run(0, static_cast<PatchId>(world.patches().size()), fitted);
  print("heights", std::span<const std::int16_t>(heights));

  world.set_samples(kLevel, heights);
  const std::vector<std::byte> file = world.file();
  print("file", std::span<const std::byte>(file));

  const Config config = World::config_for(world.info(), kLevel);
  const test::AlignedBytes memory(terrain_budget(config).cpu_bytes());
  TerrainParts parts;
  if (!parts.create(config, memory.bytes()).ok() || !parts.load(file).ok()) return false;
  const World& loaded = parts.world;
  Residency& residency = parts.residency;
  print("index_table", loaded.index_table());
  std::vector<GpuVertex> vertices(static_cast<std::size_t>(patch_vertices(kLevel)));
  std::uint32_t crc = 0;
  for (PatchId p = 0; p < loaded.patch_count(); ++p) {
    if (!residency.generate(p, kLevel, kLevel, vertices).ok()) return false;
    crc = crc32c(std::as_bytes(std::span<const GpuVertex>(vertices)), crc);
  }
  std::printf("vertices %08x\n", crc);
  print("bounds", loaded.bounds());

  CameraSettings settings;
  settings.position = {3, 18, 27};
  settings.yaw_deg = -40;
  settings.pitch_deg = -20;
  Camera camera;
  if (!make_camera(settings, camera).ok()) return false;
  ViewRequest request;
  request.camera = &camera;
  const auto select = [&] { return residency.select(parts.views_of(1), std::span(&request, 1)); };
  residency.begin_frame();
  if (!select().ok()) return false;
  PatchUpload upload;
  Status status;
  std::uint32_t uploads = 0;
  while (residency.generate_next(true, upload, status))
    uploads = crc32c(std::as_bytes(upload.vertices), uploads);
  std::printf("uploads %08x\n", uploads);
  print("morph_rows", residency.take_morph_rows().halves);
  if (!status.ok() || !select().ok()) return false;
  print("levels", parts.views[0].levels());
  print("draw_list", parts.views[0].items());
  return true;
}

}  // namespace
}  // namespace karst::core

int main() {
  if (karst::core::run()) return 0;
  std::fputs("flow_hash: a stage refused its input\n", stderr);
  return 1;
}
