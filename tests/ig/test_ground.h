// SPDX-License-Identifier: MIT
// A world in memory, a query of it, and where it lies on the earth.
#pragma once

#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ig/place/earth.h"
#include "karst/karst.h"
#include "tests/ig/all_triangles.h"

namespace karst::ig {

class TestGround {
 public:
  TestGround() : TestGround(cave_ground_file(), Geodetic{8.5, 46.25, 300}) {}
  // anchor: as Earth has it.
  TestGround(std::vector<std::byte> bytes, const std::optional<Geodetic>& anchor) : bytes_(std::move(bytes)) {
    source_ = {bytes_.size(), read, this};
    Plan plan;
    plan.placement.axes = Axes::east_up_south;
    plan.needs.queries = 1;
    plan.needs.query_level = 3;
    plan.needs.query_patches = 1024;
    plan.needs.query_tiles = 256;
    if (!make_plan(source_, plan).ok()) throw std::runtime_error("plan");
    memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kMemoryAlignment, plan.cpu_bytes)));
    if (!World::create(plan, source_, {memory_.get(), plan.cpu_bytes}, world_).ok() ||
        !world_->take_query(query_).ok() || !earth_.open(*world_, anchor).ok())
      throw std::runtime_error("world");
  }
  TestGround(const TestGround&) = delete;
  TestGround& operator=(const TestGround&) = delete;
  ~TestGround() {
    world_->release(query_);
    world_->destroy();
  }
  const World& world() const { return *world_; }
  Query& query() { return *query_; }
  const Earth& earth() const { return earth_; }

  glm::dvec3 place_of(glm::dvec3 voxels) const {
    const WorldInfo& info = world_->info();
    return glm::dvec3(info.origin_m.x, info.origin_m.y, info.origin_m.z) + voxels * info.voxel_size_m;
  }
  Geodetic geodetic(glm::dvec3 voxels) const {
    Geodetic out;
    earth_.to_geodetic(place_of(voxels), out);
    return out;
  }

 private:
  static bool read(void* user, std::uint64_t offset, std::byte* out, std::size_t count) {
    const auto& bytes = static_cast<TestGround*>(user)->bytes_;
    if (offset > bytes.size() || count > bytes.size() - offset) return false;
    std::memcpy(out, bytes.data() + offset, count);
    return true;
  }
  struct Free {
    void operator()(std::byte* p) const { std::free(p); }
  };
  std::vector<std::byte> bytes_;
  Source source_;
  std::unique_ptr<std::byte, Free> memory_;
  World* world_ = nullptr;
  Query* query_ = nullptr;
  Earth earth_;
};

}  // namespace karst::ig
