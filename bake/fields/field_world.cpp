// SPDX-License-Identifier: MIT
#include "bake/fields/field_world.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/base/parallel.h"
#include "terrain/file/byte_source.h"
#include "terrain/file/world_layout.h"
#include "terrain/patch/displacement.h"
#include "terrain/patch/heights.h"
#include "terrain/world/world.h"

namespace karst::bake {
using namespace core;
namespace {

constexpr double kFarSamples = 3;
constexpr int kMostPerVoxelLog2 = 3;
// Of a sample, by which lines that count crossings lie aside of samples: no line then meets an edge.
constexpr double kAside[2] = {1.2345e-4, 2.7183e-4};

struct Triangle {
  glm::dvec3 at[3];  // samples
};

// The nearest point of a triangle (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5), as its distance.
double distance_to(const Triangle& t, glm::dvec3 p) {
  const glm::dvec3 ab = t.at[1] - t.at[0], ac = t.at[2] - t.at[0], ap = p - t.at[0];
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return glm::length(ap);
  const glm::dvec3 bp = p - t.at[1];
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return glm::length(bp);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return glm::length(ap - ab * (d1 / (d1 - d3)));
  const glm::dvec3 cp = p - t.at[2];
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return glm::length(cp);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return glm::length(ap - ac * (d2 / (d2 - d6)));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6)
    return glm::length(bp - (t.at[2] - t.at[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))));
  const double sum = va + vb + vc;
  if (sum <= 0) return glm::length(ap);
  return glm::length(ap - ab * (vb / sum) - ac * (vc / sum));
}

// A loaded world in memory of its own.
class Loaded {
 public:
  Error load(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return path + ": it cannot be opened";
    const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
    const auto chars = std::as_bytes(std::span(text));
    bytes_.assign(chars.begin(), chars.end());
    WorldReader reader;
    if (const Status status = reader.open(ByteSource::of(bytes_)); !status.ok()) return Error(path, status);
    const core::WorldInfo& info = reader.info();
    if (info.patches == 0 || info.regions != 1)
      return path + ": it has " + (info.patches == 0 ? "no voxels" : "several regions of voxels") +
             "; a field is made of one region's surface";
    Config config = World::config_for(info, info.level, reader.ground());
    if (reader.field().exists()) return path + ": it has a field already";
    Budget budget;
    World::add_to(budget, config);
    memory_.resize(budget.cpu_bytes() + Arena::kAlignment);
    void* at = memory_.data();
    std::size_t room = memory_.size();
    std::align(Arena::kAlignment, budget.cpu_bytes(), at, room);
    Arena arena({static_cast<std::byte*>(at), budget.cpu_bytes()});
    if (const Status status = world.create(config, arena); !status.ok()) return Error(path, status);
    return Error(path, world.load(ByteSource::of(bytes_)));
  }

  World world;

 private:
  std::vector<std::byte> bytes_, memory_;
};

class Distances {
 public:
  Distances(const World& world, int per_voxel_log2, double spacing_m, FieldGrid& grid)
      : world_(world), grid_(grid) {
    const core::WorldInfo& info = world.info();
    const double samples = spacing_m > 0 ? info.voxel_size_m / spacing_m : std::ldexp(1.0, per_voxel_log2);
    a_step_ = samples / kStepsPerVoxel;
    grid.spacing_m = info.voxel_size_m / samples;
    for (int axis = 0; axis < 3; ++axis)
      grid.size[axis] = static_cast<int>(std::floor((info.extent[axis] - 1) * samples + 1e-6)) + 1;
    for (int axis = 0; axis < 3; ++axis) grid.low_m[axis] = info.origin_m[axis] + 0.5 * info.voxel_size_m;
    grid.is_placed = true;
  }

  void run(int threads) {
    collect();
    const auto rows = static_cast<std::size_t>(grid_.size.z);
    grid_.values.assign(
        static_cast<std::size_t>(grid_.size.x) * static_cast<std::size_t>(grid_.size.y) * rows,
        static_cast<float>(kFarSamples * grid_.spacing_m));
    parallel_chunks(rows, 1, threads, [&](std::size_t first, std::size_t last, int) {
      for (std::size_t z = first; z < last; ++z) slice(static_cast<int>(z));
    });
  }

 private:
  void collect() {
    const WorldPart& part = world_.parts()[0];
    const Heights heights = world_.heights();
    // Vertices as near to each other as samples are.
    const int wanted = static_cast<int>(std::ceil(std::log2(a_step_ * kStepsPerVoxel) - 1e-6));
    const int level = std::clamp(wanted, 1, heights.level), n = patch_cells(level), side = patch_side(level);
    std::vector<glm::ivec3> places(static_cast<std::size_t>(patch_vertices(level)));
    by_slice_.resize(static_cast<std::size_t>(grid_.size.z));
    for (PatchId id = 0; id < part.patches(); ++id) {
      displaced_positions(part.surface, heights, level, id, places);
      const glm::dvec3 origin = glm::dvec3(patch_origin(part.surface.volume_of(id))) - 0.5 * kStepsPerVoxel;
      const auto at = [&](int i, int j) {
        return a_step_ * (origin + glm::dvec3(places[static_cast<std::size_t>(j * side + i)]));
      };
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          add({{at(i, j), at(i + 1, j), at(i + 1, j + 1)}});
          add({{at(i, j), at(i + 1, j + 1), at(i, j + 1)}});
        }
      }
    }
  }
  void add(const Triangle& t) {
    const double low = std::min({t.at[0].z, t.at[1].z, t.at[2].z}) - kFarSamples;
    const double high = std::max({t.at[0].z, t.at[1].z, t.at[2].z}) + kFarSamples;
    const auto number = static_cast<std::uint32_t>(triangles_.size());
    triangles_.push_back(t);
    for (int z = std::max(0, static_cast<int>(std::ceil(low)));
         z <= std::min(grid_.size.z - 1, static_cast<int>(std::floor(high))); ++z)
      by_slice_[static_cast<std::size_t>(z)].push_back(number);
  }

  // All samples of one z: distances, then signs by what lies above.
  void slice(int z) {
    struct Crossing {
      double y;
      int turn;  // 1: into rock, from above
    };
    const glm::ivec3 size = grid_.size;
    std::vector<std::vector<Crossing>> columns(static_cast<std::size_t>(size.x));
    float* const values = &grid_.values[static_cast<std::size_t>(z) * static_cast<std::size_t>(size.y) *
                                        static_cast<std::size_t>(size.x)];
    const auto value = [&](int x, int y) -> float& {
      return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) +
                    static_cast<std::size_t>(x)];
    };
    const auto clamped = [](double v, int most) { return std::clamp(static_cast<int>(v), 0, most); };
    for (const std::uint32_t number : by_slice_[static_cast<std::size_t>(z)]) {
      const Triangle& t = triangles_[number];
      const glm::dvec3 low = glm::min(glm::min(t.at[0], t.at[1]), t.at[2]) - kFarSamples;
      const glm::dvec3 high = glm::max(glm::max(t.at[0], t.at[1]), t.at[2]) + kFarSamples;
      const int first_x = clamped(std::ceil(low.x), size.x), last_x = clamped(std::floor(high.x), size.x - 1);
      const int first_y = clamped(std::ceil(low.y), size.y), last_y = clamped(std::floor(high.y), size.y - 1);
      for (int x = first_x; x <= last_x; ++x) {
        for (int y = first_y; y <= last_y; ++y) {
          const auto d = static_cast<float>(distance_to(t, {x, y, z}) * grid_.spacing_m);
          value(x, y) = std::min(value(x, y), d);
        }
        double y = 0;
        const int turn = crossing(t, x + kAside[0], z + kAside[1], y);
        if (turn != 0) columns[static_cast<std::size_t>(x)].push_back({y, turn});
      }
    }
    for (int x = 0; x < size.x; ++x) {
      std::vector<Crossing>& column = columns[static_cast<std::size_t>(x)];
      std::sort(column.begin(), column.end(), [](const Crossing& a, const Crossing& b) { return a.y > b.y; });
      std::size_t next = 0;
      int inside = 0;
      for (int y = size.y - 1; y >= 0; --y) {
        for (; next < column.size() && column[next].y > y; ++next) inside += column[next].turn;
        if (inside > 0) value(x, y) = -value(x, y);
      }
    }
  }

  // Of an upright line: 1 where the triangle faces up, -1 down, 0: it does not meet it.
  static int crossing(const Triangle& t, double x, double z, double& y) {
    const auto side = [&](const glm::dvec3& a, const glm::dvec3& b) {
      return (b.x - a.x) * (z - a.z) - (b.z - a.z) * (x - a.x);
    };
    const double s0 = side(t.at[0], t.at[1]), s1 = side(t.at[1], t.at[2]), s2 = side(t.at[2], t.at[0]);
    const bool all_down = s0 > 0 && s1 > 0 && s2 > 0, all_up = s0 < 0 && s1 < 0 && s2 < 0;
    if (!all_down && !all_up) return 0;
    const double sum = s0 + s1 + s2;
    y = (s1 * t.at[0].y + s2 * t.at[1].y + s0 * t.at[2].y) / sum;
    // x to the east and z to the south: from above, counter-clockwise is negative.
    return all_up ? 1 : -1;
  }

  const World& world_;
  FieldGrid& grid_;
  double a_step_ = 0;  // samples
  std::vector<Triangle> triangles_;
  std::vector<std::vector<std::uint32_t>> by_slice_;
};

}  // namespace

bool is_world(std::string_view head) {
  const auto& magic = world_layout::kMagic;
  return head.size() >= magic.size() && std::memcmp(head.data(), magic.data(), magic.size()) == 0;
}

Error read_world_surface(const std::string& path, double spacing_m, int threads, FieldGrid& grid) {
  grid = {};
  const auto loaded = std::make_unique<Loaded>();
  if (Error error = loaded->load(path); !error.ok()) return error;
  const int log2 = std::min(loaded->world.info().level, kMostPerVoxelLog2);
  Distances distances(loaded->world, log2, spacing_m, grid);
  std::uint64_t samples = 1;
  for (int axis = 0; axis < 3; ++axis) {
    if (grid.size[axis] < 2 || grid.size[axis] > FieldGrid::kMostSide)
      return path + ": its sides are not within 2 to 4080 samples; say another --field-spacing";
    samples *= static_cast<std::uint64_t>(grid.size[axis]);
  }
  if (samples > FieldGrid::kMostSamples)
    return path + ": it has more than 2^26 samples; say a larger --field-spacing than " +
           std::to_string(grid.spacing_m);
  distances.run(threads);
  return {};
}

}  // namespace karst::bake
