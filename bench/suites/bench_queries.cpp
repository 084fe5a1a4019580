// SPDX-License-Identifier: MIT
// One thread, everything asked once before it is timed. Batches are rays of a turning sensor of 64 beams that
// stands 2 m above the ground at 16 places, and rays between random places of the world's box; single calls
// are the same rays in random order, each timed alone, less what reading the clock takes.
// Batches are timed by what the thread ran on its core.
#include "bench/suites/bench_queries.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <vector>

#include <glm/geometric.hpp>

#include "app/common/arguments.h"
#include "terrain/query/query.h"
#include "terrain/world/terrain_parts.h"

namespace karst::bench {
namespace {

using namespace core;
using namespace app;
using Clock = std::chrono::steady_clock;

double since_ns(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

// What this thread ran on a core: other programs on the machine do not count.
double thread_ns() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e9 + static_cast<double>(t.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// SplitMix64 (Steele et al. 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double unit() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return static_cast<double>((z ^ z >> 31) >> 11) * 0x1p-53;
  }
  glm::dvec3 in(glm::dvec3 low, glm::dvec3 high) {
    const double x = unit();
    const double y = unit();
    return low + (high - low) * glm::dvec3(x, y, unit());
  }

 private:
  std::uint64_t state_;
};

struct Rays {
  std::vector<glm::dvec3> from, to;
};

class QuerySuite {
 public:
  QuerySuite(const core::World& terrain, core::Query& query, const QuerySuiteOptions& options)
      : terrain_(terrain), query_(query), options_(options), clock_ns_(clock_cost()) {
    const LatticeBox box = terrain.box();
    low_ = glm::dvec3(box.min) / double{kStepsPerVoxel};
    high_ = glm::dvec3(box.max) / double{kStepsPerVoxel};
  }

  void run() {
    const Rays sensor = sensor_rays();
    const Rays random = random_rays();
    batch("sensor, in its order", sensor);
    batch("random", random);
    single("ray, sensor", sensor);
    single("ray, random", random);
    const std::vector<glm::dvec3> places = random_places();
    QueryHit hit;
    time_each("ground", places.size(),
              [&](std::size_t n) { query_.ground(high(places[n]), 1.0, core::Wait::for_file, hit); });
    time_wheels(places);
    std::vector<QueryHit> column(16);
    time_each("column", places.size(),
              [&](std::size_t n) { query_.column(places[n], core::Wait::for_file, column); });
    time_each("inside", places.size(),
              [&](std::size_t n) { inside_ += query_.inside(places[n], core::Wait::for_file); });
    const double radius = 0.5 / terrain_.info().voxel_size_m;
    time_each("sphere of 0.5 m, 20 m of way", places.size(), [&](std::size_t n) {
      const glm::dvec3 way =
          glm::normalize(random.to[n] - random.from[n]) * 20.0 / terrain_.info().voxel_size_m;
      query_.sphere(places[n], places[n] + way, radius, core::Wait::for_file, hit);
    });
    PickedVoxel picked;
    time_each("pick of a voxel", places.size(), [&](std::size_t n) {
      pick_voxel(terrain_.octree(), random.from[n], random.to[n], terrain_.octree().depth(), picked);
    });
  }

 private:
  static double clock_cost() {
    std::vector<double> ns(1001);
    for (double& v : ns) v = since_ns(Clock::now());
    return median(ns);
  }

  glm::dvec3 high(glm::dvec3 place) const { return {place.x, high_.y + 1.0, place.z}; }

  Rays sensor_rays() {
    Rays rays;
    Random random(1);
    const double reach = 120.0 / terrain_.info().voxel_size_m;
    constexpr std::uint32_t kPlaces = 16;
    constexpr std::uint32_t kBeams = 64;
    const std::uint32_t turns = std::max(1u, options_.rays / (kPlaces * kBeams));
    for (std::uint32_t p = 0; p < kPlaces; ++p) {
      QueryHit ground;
      while (!query_.ground(high(random.in(low_, high_)), 1.0, core::Wait::for_file, ground)) {
      }
      const glm::dvec3 eye = ground.place + glm::dvec3(0, 2.0 / terrain_.info().voxel_size_m, 0);
      for (std::uint32_t turn = 0; turn < turns; ++turn) {
        const double yaw = 6.283185307179586 * turn / turns;
        for (std::uint32_t beam = 0; beam < kBeams; ++beam) {
          const double pitch =
              0.2617993877991494 - 0.6981317007977318 * beam / (kBeams - 1);  // 15 to -25 degrees
          rays.from.push_back(eye);
          rays.to.push_back(eye + reach * glm::dvec3(std::cos(pitch) * std::sin(yaw), std::sin(pitch),
                                                     -std::cos(pitch) * std::cos(yaw)));
        }
      }
    }
    return rays;
  }

  Rays random_rays() {
    Rays rays;
    Random random(2);
    for (std::uint32_t n = 0; n < options_.rays; ++n) {
      rays.from.push_back(random.in(low_, high_));
      rays.to.push_back(random.in(low_, high_));
    }
    return rays;
  }

  std::vector<glm::dvec3> random_places() const {
    std::vector<glm::dvec3> places;
    Random random(3);
    for (std::uint32_t n = 0; n < std::min(options_.rays, 16'384u); ++n)
      places.push_back(random.in(low_, high_));
    return places;
  }

  void batch(const char* name, const Rays& rays) {
    std::vector<QueryHit> hits(rays.from.size());
    std::vector<double> ns;
    for (int round = 0; round <= options_.rounds; ++round) {
      const double start = thread_ns();
      query_.rays(rays.from, rays.to, core::Wait::for_file, hits);
      if (round > 0) ns.push_back(thread_ns() - start);
    }
    const auto met = std::count_if(hits.begin(), hits.end(), [](const QueryHit& h) { return h.found(); });
    const double each = median(ns) / static_cast<double>(hits.size());
    std::printf("batch of rays: %-22s %9.3f million a second, %6.0f ns each; %.0f %% met the surface\n", name,
                1e3 / each, each, 100.0 * static_cast<double>(met) / static_cast<double>(hits.size()));
  }

  void single(const char* name, const Rays& rays) {
    QueryHit hit;
    const std::size_t count = std::min<std::size_t>(rays.from.size(), 16'384);
    time_each(name, count, [&](std::size_t n) {
      // Far apart in the list, so that none finds what the one before it left in the processor's caches.
      const std::size_t at = n * 7919 % rays.from.size();
      query_.ray(rays.from[at], rays.to[at], core::Wait::for_file, hit);
    });
  }

  void time_wheels(const std::vector<glm::dvec3>& places) {
    const double base = 1.25 / terrain_.info().voxel_size_m;  // half of a car's wheelbase, about
    double sum = 0;
    time_each("four wheels and a normal", places.size(), [&](std::size_t n) {
      QueryHit wheel[4];
      for (int w = 0; w < 4; ++w) {
        const glm::dvec3 at =
            high(places[n]) + glm::dvec3((w & 1) != 0 ? base : -base, 0, w < 2 ? -base : base);
        query_.ground(at, 1.0, core::Wait::for_file, wheel[w]);
      }
      const glm::dvec3 up = glm::cross(wheel[3].place - wheel[0].place, wheel[1].place - wheel[2].place);
      sum += up.y / glm::length(up);
    });
    inside_ += sum > 1e30;
  }

  void time_each(const char* name, std::size_t count, const std::function<void(std::size_t)>& ask) {
    std::vector<double> medians, tails;
    for (int round = 0; round <= options_.rounds; ++round) {
      std::vector<double> ns(count);
      for (std::size_t n = 0; n < count; ++n) {
        const auto start = Clock::now();
        ask(n);
        ns[n] = std::max(0.0, since_ns(start) - clock_ns_);
      }
      if (round == 0) continue;
      std::sort(ns.begin(), ns.end());
      medians.push_back(ns[count / 2]);
      tails.push_back(ns[count - 1 - count / 100]);
    }
    std::printf("%-37s %9.0f ns in the median, %6.0f ns at 99 %%\n", name, median(medians), median(tails));
  }

  const core::World& terrain_;
  core::Query& query_;
  const QuerySuiteOptions& options_;
  double clock_ns_;
  glm::dvec3 low_, high_;
  std::uint64_t inside_ = 0;
};

int fail(const Status& status) {
  print_error("karst-bench", Error("queries", status).text());
  return kExitFailure;
}

std::span<std::byte> aligned(std::vector<std::byte>& memory, std::size_t bytes) {
  memory.resize(bytes + Arena::kAlignment);
  const std::size_t at = reinterpret_cast<std::uintptr_t>(memory.data()) % Arena::kAlignment;
  return std::span(memory).subspan((Arena::kAlignment - at) % Arena::kAlignment, bytes);
}

}  // namespace

int run_query_suite(std::span<const std::byte> file, const QuerySuiteOptions& options) {
  WorldReader reader;
  if (const Status opened = reader.open(ByteSource::of(file)); !opened.ok()) return fail(opened);
  const WorldInfo& info = reader.info();
  const Config config = core::World::config_for(info, info.level);
  std::vector<std::byte> memory;
  TerrainParts parts;
  Status status = parts.create(config, aligned(memory, terrain_budget(config).cpu_bytes()));
  if (status.ok()) status = parts.load(file);
  const core::World& terrain = parts.world;
  if (!status.ok()) return fail(status);
  if (terrain.patch_count() == 0) return fail({StatusCode::invalid_argument, "has no surface", "world"});
  core::Query::Limits limits;
  limits.level = options.level;
  limits.patches = options.patches == 0 ? terrain.patch_count() : options.patches;
  limits.max_level = std::max(info.level, options.level);
  Budget budget;
  core::Query::add_to(budget, limits);
  std::vector<std::byte> query_memory;
  Arena arena(aligned(query_memory, budget.cpu_bytes()));
  core::Query query;
  if (status = query.create(limits, arena); !status.ok()) return fail(status);
  QueryWorld world;
  world.surface = terrain.surface();
  world.bounds = terrain.bounds();
  world.tree = &terrain.tree();
  world.heights = terrain.heights();
  world.height_blocks = info.height_blocks;
  if (status = query.set_world(world); !status.ok()) return fail(status);
  std::printf("%s: %u patches; level %d, %u of them kept in %zu bytes\n", info.name, terrain.patch_count(),
              query.level(), limits.patches, budget.cpu_bytes());
  QuerySuite(terrain, query, options).run();
  return kExitOk;
}

}  // namespace karst::bench
