// SPDX-License-Identifier: MIT
// Isosurfaces of one field by OpenVDB's volumeToMesh and by karst, in turns, in one process and thread.
// Usage: volume_to_mesh [ROUNDS]; see ../openvdb.sh.
#include <openvdb/openvdb.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>

#include "terrain/field/scalar_field.h"
#include "terrain/isosurface/extract_block.h"

namespace {

using namespace karst::core;

constexpr int kX = 256, kY = 64, kZ = 256;  // samples
constexpr double kReach = 3;                // samples from the surface to which the field is known

// Hills and six caves, in samples; below 0 in the rock.
double field(double x, double y, double z) {
  const double height = 30 + 9 * std::sin(x / 23) * std::cos(z / 31) + 5 * std::sin(x / 11 + z / 17) +
                        1.5 * std::sin(x / 5.3) * std::sin(z / 4.7);
  double d = (y - height) / 1.3;
  for (int n = 0; n < 6; ++n) {
    const double cx = 30 + 38 * n, cz = 128 + 75 * std::sin(n * 1.7), cy = 26 - n, r = 8 + 0.8 * n;
    d = std::max(d, r - std::sqrt((x - cx) * (x - cx) + (y - cy) * (y - cy) + (z - cz) * (z - cz)));
  }
  return d;
}

double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 21;
  openvdb::initialize();
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  auto grid = openvdb::FloatGrid::create(static_cast<float>(kReach));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto access = grid->getAccessor();
  std::vector<std::uint32_t> table(kX / 16 * kY / 16 * kZ / 16);
  std::vector<std::int8_t> pool(std::size_t{kX} * kY * kZ);
  ScalarField<std::int8_t> ours;
  if (!ours.create({kX / 16, kY / 16, kZ / 16}, table, pool).ok()) return 1;
  for (int bz = 0; bz < kZ / 16; ++bz) {
    for (int by = 0; by < kY / 16; ++by) {
      for (int bx = 0; bx < kX / 16; ++bx) {
        const auto out = ours.open({bx, by, bz});
        for (int n = 0; n < 4096; ++n) {
          const int x = bx * 16 + (n & 15), y = by * 16 + (n >> 4 & 15), z = bz * 16 + (n >> 8);
          const double d = field(x, y, z);
          if (std::fabs(d) < kReach) access.setValue({x, y, z}, static_cast<float>(d));
          out[static_cast<std::size_t>(n)] =
              static_cast<std::int8_t>(std::clamp(std::floor(d * 127 / kReach), -128.0, 127.0));
        }
        ours.close({bx, by, bz});
      }
    }
  }
  openvdb::tools::signedFloodFill(grid->tree());

  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  std::vector<IsoVertex> vertices(28'000);
  std::vector<std::uint16_t> indices(3 * 40'000);
  std::vector<std::byte> bytes(ExtractBlock<std::int8_t>::room_bytes() + 16);
  void* room = bytes.data();
  std::size_t space = bytes.size();
  std::align(16, ExtractBlock<std::int8_t>::room_bytes(), room, space);
  std::vector<double> theirs_ns, ours_ns;
  std::size_t their_vertices = 0, their_triangles = 0, our_vertices = 0, our_triangles = 0;
  for (int n = 0; n < rounds; ++n) {
    points.clear();
    triangles.clear();
    quads.clear();
    double start = cpu_ms();
    openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0.0, 0.0);
    theirs_ns.push_back((cpu_ms() - start) * 1e6 / static_cast<double>(points.size()));
    their_vertices = points.size();
    their_triangles = triangles.size() + 2 * quads.size();

    our_vertices = our_triangles = 0;
    start = cpu_ms();
    for (int z = 0; z < kZ; z += 16) {
      for (int y = 0; y < kY; y += 16) {
        for (int x = 0; x < kX; x += 16) {
          ExtractBlock<std::int8_t> job;
          job.field = &ours;
          job.corner = {x, y, z};
          job.vertices = vertices;
          job.triangles = indices;
          ExtractBlock<std::int8_t>::Result made;
          if (!job.run({static_cast<std::byte*>(room), space}, made).ok()) return 1;
          our_vertices += made.vertices;
          our_triangles += made.triangles;
        }
      }
    }
    ours_ns.push_back((cpu_ms() - start) * 1e6 / static_cast<double>(our_vertices));
  }
  std::printf("OpenVDB volumeToMesh: %zu vertices, %zu triangles, %.0f ns of CPU a vertex (median of %d)\n",
              their_vertices, their_triangles, median(theirs_ns), rounds);
  std::printf("karst, with normals:  %zu vertices, %zu triangles, %.0f ns\n", our_vertices, our_triangles,
              median(ours_ns));
  std::printf("a vertex: %.2f; the whole surface: %.2f of OpenVDB's time\n",
              median(ours_ns) / median(theirs_ns),
              median(ours_ns) * static_cast<double>(our_vertices) /
                  (median(theirs_ns) * static_cast<double>(their_vertices)));
  return 0;
}
