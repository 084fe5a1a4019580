// SPDX-License-Identifier: MIT
#include "bake/carve/cave_lights.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace karst::bake {
namespace {

constexpr float kRadius = 8;  // voxels: across a hall
constexpr float kReach = 10;  // voxels; more room than this is no cave
// Warm and cold by turns, as lamps and as daylight from a shaft.
constexpr glm::vec3 kColours[] = {{2.6f, 1.75f, 0.95f}, {1.2f, 1.5f, 1.8f}};

class Rock {
 public:
  Rock(const Octree& octree, glm::ivec3 extent) : extent_(extent) {
    filled_.resize(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.y) *
                   static_cast<std::size_t>(extent.z));
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        for (int x = 0; x < extent.x; ++x) filled_[at({x, y, z})] = octree.filled({x, y, z}) ? 1 : 0;
      }
    }
  }

  bool filled(glm::ivec3 v) const { return filled_[at(v)] != 0; }

  bool under_rock(glm::ivec3 v) const {
    for (++v.y; v.y < extent_.y; ++v.y) {
      if (filled(v)) return true;
    }
    return false;
  }

  // Distance to the nearest voxel of rock or of the open sky's columns, up to kReach.
  float room(glm::ivec3 v) const {
    const int reach = static_cast<int>(kReach);
    float nearest = kReach * kReach;
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const auto square = static_cast<float>(x * x + y * y + z * z);
          const glm::ivec3 other = v + glm::ivec3(x, y, z);
          if (square < nearest && (!inside(other) || filled(other))) nearest = square;
        }
      }
    }
    return std::sqrt(nearest);
  }

 private:
  bool inside(glm::ivec3 v) const {
    return v.x >= 0 && v.y >= 0 && v.z >= 0 && v.x < extent_.x && v.y < extent_.y && v.z < extent_.z;
  }
  std::size_t at(glm::ivec3 v) const {
    return (static_cast<std::size_t>(v.z) * static_cast<std::size_t>(extent_.y) +
            static_cast<std::size_t>(v.y)) *
               static_cast<std::size_t>(extent_.x) +
           static_cast<std::size_t>(v.x);
  }

  glm::ivec3 extent_;
  std::vector<std::uint8_t> filled_;
};

struct Place {
  glm::ivec3 voxel{0};
  float room = 0;
};

}  // namespace

std::vector<PointLight> PlaceCaveLights::run() const {
  const Rock rock(*octree, extent);
  std::vector<Place> places;
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      for (int x = 0; x < extent.x; ++x) {
        const glm::ivec3 voxel(x, y, z);
        if (rock.filled(voxel) || !rock.under_rock(voxel)) continue;
        const float room = rock.room(voxel);
        if (room >= least_room) places.push_back({voxel, room});
      }
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.room > b.room; });
  std::vector<PointLight> lights;
  for (const Place& place : places) {
    if (lights.size() >= static_cast<std::size_t>(most)) break;
    const glm::vec3 position = glm::vec3(place.voxel) + 0.5f;
    const bool near = std::any_of(lights.begin(), lights.end(), [&](const PointLight& light) {
      return glm::distance(light.position, position) < apart;
    });
    if (near) continue;
    PointLight light;
    light.position = position;
    light.radius = kRadius;
    light.colour = kColours[lights.size() % 2];
    lights.push_back(light);
  }
  return lights;
}

}  // namespace karst::bake
