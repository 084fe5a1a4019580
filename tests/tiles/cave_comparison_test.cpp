// SPDX-License-Identifier: MIT
// The same cave as a region of patches and as one of a field: bytes, triangles at the finest, time to bake,
// and how far each is from the shape that was asked for, both ways (tests/bench/cave.sh prints it).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include <glm/geometric.hpp>

#include "bake/carve/carve.h"
#include "terrain/blocks/isosurface.h"
#include "terrain/file/world_reader.h"
#include "terrain/patch/displacement.h"
#include "terrain/world/world.h"
#include "tests/support/process.h"
#include "tests/support/query_world.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::SoupTriangle;

// A slope that bilinear samples have exactly, and what is carved into it.
double land(double x, double z) {
  return 200 + 0.3 * x + 0.1 * z;
}
struct Slope final : bake::Solid {
  double value_m(glm::dvec3 p) const override { return (land(p.x, p.z) - p.y) / std::sqrt(1.1); }
};
// A tunnel into it, a chamber at its end, and a pillar of 1 m in that.
constexpr const char* kCave = R"([
  {"shape": "capsule", "op": "empty", "radius": 8, "points": [[-60, 200, 0], [40, 200, 0], [120, 202, 30]]},
  {"shape": "sphere", "op": "empty", "center": [120, 204, 30], "radius": 15},
  {"shape": "capsule", "op": "fill", "radius": 1, "points": [[122, 180, 33], [122, 225, 33]]}
])";

std::vector<std::byte> read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

// The number behind a name in JSON.
double number_in(const std::string& json, const std::string& name) {
  const std::size_t regions = json.find("\"regions\"");
  const std::size_t at = json.find("\"" + name + "\":", regions);
  return at == std::string::npos ? -1 : std::atof(json.c_str() + at + name.size() + 3);
}

struct Baked {
  std::vector<SoupTriangle> triangles;  // metres
  double bytes = 0, seconds = 0, vertex_m = 0;
  glm::dvec3 low{0.0}, high{0.0};  // of the region
};

SoupTriangle triangle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  SoupTriangle t{};
  t.corner[0] = a;
  t.corner[1] = b;
  t.corner[2] = c;
  return t;
}

// Lattice steps from the region's corner to metres.
struct Placed {
  glm::dvec3 origin_m;
  double step_m;
  glm::dvec3 operator()(glm::dvec3 steps) const { return origin_m + step_m * steps; }
};

void add_patches(const World& world, const Placed& placed, std::vector<SoupTriangle>& out) {
  const WorldPart& part = world.parts()[0];
  const Heights heights = world.heights();
  const int n = patch_cells(heights.level);
  std::vector<glm::ivec3> places(static_cast<std::size_t>(patch_vertices(heights.level)));
  for (PatchId id = 0; id < part.patches(); ++id) {
    displaced_positions(part.surface, heights, heights.level, id, places);
    const glm::dvec3 origin(patch_origin(part.surface.volume_of(id)));
    const auto at = [&](int i, int j) {
      return placed(origin + glm::dvec3(places[static_cast<std::size_t>(j * (n + 1) + i)]));
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        out.push_back(triangle(at(i, j), at(i + 1, j), at(i + 1, j + 1)));
        out.push_back(triangle(at(i, j), at(i + 1, j + 1), at(i, j + 1)));
      }
    }
  }
}

void add_field(World& world, const Placed& placed, std::vector<SoupTriangle>& out) {
  Config config;
  config.field_blocks = static_cast<std::uint32_t>(world.field().info().table_blocks());
  config.field_meshes = 4 * world.field().info().stored + 64;
  config.field_vertex_pages = config.field_index_pages = 64 * world.field().info().stored + 4'096;
  config.rim_edges = kMostRimEdges;
  Budget budget;
  Isosurface::add_to(budget, config);
  test::AlignedBytes memory(budget.cpu_bytes());
  Arena arena(memory.bytes());
  Isosurface isosurface;
  ASSERT_TRUE(isosurface.create(config, arena).ok());
  isosurface.attach(world.field(),
                    {glm::ivec3(0), std::int64_t{kStepsPerVoxel} << world.ground().lattice_size});
  BlockEye eye;
  eye.steps_per_step = std::numeric_limits<float>::infinity();
  isosurface.begin_frame();
  isosurface.choose({&eye, 1});
  std::unordered_map<std::uint32_t, std::vector<glm::dvec3>> meshes;  // by first page
  MeshUpload upload;
  Status status;
  while (isosurface.make_next(upload, status)) {
    std::vector<glm::dvec3>& mesh = meshes[upload.first_page];
    for (const GpuVertex& v : upload.vertices) {
      const glm::dvec3 steps = glm::dvec3(upload.origin) * double{kStepsPerVoxel} +
                               glm::dvec3(v.position[0], v.position[1], v.position[2]);
      mesh.push_back(placed(std::ldexp(1.0, upload.size) * steps));
    }
  }
  ASSERT_TRUE(status.ok());
  ASSERT_EQ(isosurface.error_scale(), 1.0f);
  const MeshPages pages = isosurface.pool().pages(0);
  for (const MeshItem& item : isosurface.list(0, nullptr).items) {
    const std::vector<glm::dvec3>& mesh = meshes[item.first_page];
    std::uint32_t page = item.first_index_page;
    for (std::uint32_t at = 0; at < item.indices; at += 3) {
      if (at > 0 && at % kIndexPage == 0) page = pages.next_index_page[page];
      const std::uint16_t* const v = &pages.indices[std::size_t{page} * kIndexPage + at % kIndexPage];
      out.push_back(triangle(mesh[v[0]], mesh[v[1]], mesh[v[2]]));
    }
  }
}

void bake_cave(const test::Folder& folder, const std::string& kind, const std::string& voxel,
               const std::string& level, Baked& baked) {
  const std::string world_path = folder.path(kind + ".karst");
  const test::ProcessResult made = test::run_process(
      KARST_BAKE_PATH, {folder.path("slope.asc"), "--ground", "--materials", "none", "--carve",
                        folder.path("cave.json"), "--carve-as", kind, "--voxel", voxel, "--levels", level,
                        "--threads", "1", "--json", "--quiet", "-o", world_path});
  ASSERT_EQ(made.code, 0) << made.err;
  baked.bytes = number_in(made.out, "bytes");
  baked.seconds = number_in(made.out, "seconds");
  const std::vector<std::byte> file = read_all(world_path);
  WorldReader reader;
  ASSERT_TRUE(reader.open(ByteSource::of(file)).ok());
  Config config = World::config_for(reader.info(), reader.info().level, reader.ground());
  if (reader.field().exists()) {
    config.field_blocks = static_cast<std::uint32_t>(reader.field().table_blocks());
    config.field_sample_blocks = reader.field().stored;
  }
  Budget budget;
  World::add_to(budget, config);
  test::AlignedBytes memory(budget.cpu_bytes());
  Arena arena(memory.bytes());
  World world;
  ASSERT_TRUE(world.create(config, arena).ok());
  ASSERT_TRUE(world.load(ByteSource::of(file)).ok());
  const core::WorldInfo& info = world.info();
  const Placed placed{{info.origin_m[0], info.origin_m[1], info.origin_m[2]},
                      info.voxel_size_m / kStepsPerVoxel};
  // Where shapes are told from what lies outside: two voxels from the sides.
  baked.low = placed(glm::dvec3(2.5 * kStepsPerVoxel));
  baked.high = placed((glm::dvec3(info.extent) - 2.5) * double{kStepsPerVoxel});
  if (reader.field().exists()) {
    baked.vertex_m = std::ldexp(info.voxel_size_m, reader.field().cell_log2 - kMostCellLog2);
    add_field(world, placed, baked.triangles);
  } else {
    baked.vertex_m = std::ldexp(info.voxel_size_m, -info.level);
    add_patches(world, placed, baked.triangles);
  }
}

// Triangles by the cubes that they reach.
class Soup {
 public:
  explicit Soup(const std::vector<SoupTriangle>& all) : all_(all) {
    for (std::uint32_t n = 0; n < all.size(); ++n) {
      glm::ivec3 low(1 << 30), high(-(1 << 30));
      for (const glm::dvec3& corner : all[n].corner) {
        low = glm::min(low, cell(corner));
        high = glm::max(high, cell(corner));
      }
      glm::ivec3 c;
      for (c.z = low.z; c.z <= high.z; ++c.z) {
        for (c.y = low.y; c.y <= high.y; ++c.y) {
          for (c.x = low.x; c.x <= high.x; ++c.x) cells_[key(c)].push_back(n);
        }
      }
    }
  }
  // kFar: none within a cube around.
  static constexpr double kFar = 4;
  double distance(glm::dvec3 from) const {
    double least = kFar;
    const glm::ivec3 middle = cell(from);
    for (int o = 0; o < 27; ++o) {
      const auto found = cells_.find(key(middle + glm::ivec3(o % 3 - 1, o / 3 % 3 - 1, o / 9 - 1)));
      if (found == cells_.end()) continue;
      for (const std::uint32_t n : found->second)
        least = std::min(least, test::triangle_distance(from, all_[n]));
    }
    return least;
  }

 private:
  static glm::ivec3 cell(glm::dvec3 p) { return glm::ivec3(glm::floor(p / kFar)); }
  static std::int64_t key(glm::ivec3 c) { return (std::int64_t{c.x} * 65536 + c.y) * 65536 + c.z; }
  const std::vector<SoupTriangle>& all_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> cells_;
};

struct Error {
  double mean = 0, p99 = 0, most = 0;
};
Error error_of(std::vector<double> off) {
  Error e;
  if (off.empty()) return e;
  std::sort(off.begin(), off.end());
  for (const double d : off) e.mean += d / static_cast<double>(off.size());
  e.p99 = off[off.size() * 99 / 100];
  e.most = off.back();
  return e;
}

bool inside(const Baked& baked, glm::dvec3 p) {
  return p.x > baked.low.x && p.x < baked.high.x && p.z > baked.low.z && p.z < baked.high.z;
}

// Points of the shape's surface, where it is smooth, from random ones beside it.
std::vector<glm::dvec3> points_of(const bake::Solid& solid, const Baked& baked, int count) {
  std::mt19937 random(11);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  std::vector<glm::dvec3> points;
  while (static_cast<int>(points.size()) < count) {
    glm::dvec3 p(between(-90, 140), 0, between(-20, 60));
    p.y = between(180, land(p.x, p.z) + 4);
    if (std::abs(solid.value_m(p)) > 4) continue;
    for (int step = 0; step < 30; ++step) {
      glm::dvec3 slope;
      for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 d(0.0);
        d[axis] = 1e-4;
        slope[axis] = (solid.value_m(p + d) - solid.value_m(p - d)) / 2e-4;
      }
      const double square = glm::dot(slope, slope);
      if (square < 0.1) break;
      p -= solid.value_m(p) * slope / square;
    }
    if (std::abs(solid.value_m(p)) < 1e-7 && inside(baked, p)) points.push_back(p);
  }
  return points;
}

TEST(CaveComparison, PatchesBesideAField) {
  const test::Folder folder;
  {
    std::ofstream dem(folder.path("slope.asc"));
    dem << "ncols 129\nnrows 129\nxllcorner 0\nyllcorner 0\ncellsize 10\n";
    for (int row = 0; row < 129; ++row) {
      for (int column = 0; column < 129; ++column) dem << land(10 * column - 640, 10 * row - 640) << ' ';
      dem << '\n';
    }
    std::ofstream(folder.path("cave.json")) << kCave;
  }
  std::vector<bake::CarveShape> shapes;
  ASSERT_TRUE(bake::parse_carve(kCave, "cave", shapes).ok());
  const Slope slope;
  bake::WorldGrid grid;
  grid.voxel_m = 4;
  grid.origin_m = {-400, 0, -400};
  grid.extent = {200, 100, 200};
  bake::CarvedSolid solid(slope, shapes, grid);
  ASSERT_TRUE(solid.build().ok());
  std::printf("FIGURE %-8s %6s %9s %8s %7s | %-26s | %-26s\n", "kind", "vertex", "triangles", "bytes",
              "bake s", "to the shape: mean 99% most", "from the shape: mean 99% most");
  for (const char* const level : {"2", "3"}) {
    std::array<Error, 2> there, back;
    double cell = 0;
    for (int kind = 0; kind < 2; ++kind) {
      const char* const name = kind == 0 ? "patches" : "field";
      Baked baked;
      ASSERT_NO_FATAL_FAILURE(bake_cave(folder, name, "4", level, baked));
      std::vector<double> to_shape, from_shape;
      for (const SoupTriangle& t : baked.triangles) {
        for (const glm::dvec3& p : {t.corner[0], (t.corner[0] + t.corner[1] + t.corner[2]) / 3.0}) {
          if (inside(baked, p)) to_shape.push_back(std::abs(solid.value_m(p)));
        }
      }
      const Soup soup(baked.triangles);
      for (const glm::dvec3 p : points_of(solid, baked, 20'000)) from_shape.push_back(soup.distance(p));
      const auto k = static_cast<std::size_t>(kind);
      cell = baked.vertex_m;
      there[k] = error_of(to_shape);
      back[k] = error_of(from_shape);
      std::printf("FIGURE %-8s %4.2f m %9zu %8.0f %7.2f | %7.4f %7.4f %7.3f m  | %7.4f %7.4f %7.3f m\n", name,
                  baked.vertex_m, baked.triangles.size(), baked.bytes, baked.seconds, there[k].mean,
                  there[k].p99, there[k].most, back[k].mean, back[k].p99, back[k].most);
    }
    // The field has the pillar, and is exact where the shape is smooth. Sharp edges are cut off.
    EXPECT_LT(there[1].mean, 0.02 * cell);
    EXPECT_LT(back[1].mean, 0.02 * cell);
    EXPECT_LT(there[1].most, cell);
    EXPECT_LT(back[1].most, 3 * cell);
    EXPECT_LT(back[1].most, back[0].most);
  }
}

}  // namespace
}  // namespace karst::core
