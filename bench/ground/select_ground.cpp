// SPDX-License-Identifier: MIT
#include "bench/ground/select_ground.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/measure/bench_clock.h"
#include "terrain/world/terrain_parts.h"

namespace karst::bench {
namespace {

// Of each frame; the least counts, so that other programs on the machine do not.
constexpr int kRepeats = 5;
// Written before the selection that is timed cold: more than caches of a core hold.
constexpr std::size_t kOtherWork = std::size_t{8} << 20;
constexpr int kMostRounds = 200;  // of asking for what a frame lacks

double part(std::vector<double>& values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// Of nodes and items, but not of families, which depend on when tiles came.
std::uint64_t hash_of(const core::GroundView& view) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  const auto mix = [&](std::uint64_t word) { hash = (hash ^ word) * 0x100000001b3u; };
  for (const core::GroundView::Node& node : view.nodes()) {
    mix(std::uint64_t{static_cast<std::uint32_t>(node.key.x)} << 32 | static_cast<std::uint32_t>(node.key.z));
    mix(static_cast<std::uint64_t>(node.key.size) << 8 | (node.in_view ? 4u : 0u) | (node.refused ? 2u : 0u) |
        (node.is_split() ? 1u : 0u));
    if (!node.in_view) continue;
    mix(std::uint64_t{std::bit_cast<std::uint32_t>(node.threshold)} << 32 |
        std::bit_cast<std::uint32_t>(node.least_apparent));
    if (!node.is_split()) continue;
    for (const std::int32_t around : node.around) mix(static_cast<std::uint32_t>(around));
  }
  for (std::size_t n = 0; n < view.items().size(); ++n) {
    const core::NodeKey key = view.node_of(n).key;
    mix(std::uint64_t{static_cast<std::uint32_t>(key.x)} << 32 | static_cast<std::uint32_t>(key.z));
    mix(static_cast<std::uint64_t>(view.items()[n].lower_edges) << 8 | view.items()[n].walls);
  }
  return hash;
}

}  // namespace

Error run_select_ground(BenchView& view, const StageView& look, std::string_view name,
                        std::span<const core::Camera> cameras, int rounds) {
  core::TerrainParts& parts = static_cast<core::WorldObject&>(view.stage().world()).terrain;
  core::Ground& ground = parts.ground;
  ground.forget();
  std::vector<double> us, cold_us, ns_a_node;
  std::vector<std::uint8_t> others(kOtherWork);
  double drawn = 0, visited = 0, triangles = 0, lacking = 0;
  std::uint64_t hash = 0;
  for (int round = 0; round < rounds; ++round) {
    for (const core::Camera& camera : cameras) {
      core::ViewRequest asked;
      asked.camera = &camera;
      asked.lod.error_px = look.view.error_px;
      asked.width_px = static_cast<int>(look.view.width_px);
      asked.height_px = static_cast<int>(look.view.height_px);
      parts.residency.begin_frame();
      if (const Status status = parts.residency.select(parts.views_of(1), std::span(&asked, 1), false);
          !status.ok())
        return Error(std::string(name), status);
      core::GroundRequest request;
      request.camera = &camera;
      request.scale = parts.views[0].error_scale();
      request.error_px = look.view.error_px;
      ground.begin_frame();
      for (int n = 0; n < kMostRounds; ++n) {
        ground.select(0, request);
        ground.ask();
        if (ground.view(0).result().lacks_tile == 0 || !ground.wait()) break;
        ground.poll();
      }
      for (std::size_t n = 0; n < others.size(); n += 64) ++others[n];
      const double cold = clock_ms(CLOCK_THREAD_CPUTIME_ID);
      ground.select(0, request);
      cold_us.push_back((clock_ms(CLOCK_THREAD_CPUTIME_ID) - cold) * 1e3);
      double least_us = 1e9;
      for (int n = 0; n < kRepeats; ++n) {
        const double start = clock_ms(CLOCK_THREAD_CPUTIME_ID);
        ground.select(0, request);
        least_us = std::min(least_us, (clock_ms(CLOCK_THREAD_CPUTIME_ID) - start) * 1e3);
      }
      const core::GroundView::Result& result = ground.view(0).result();
      us.push_back(least_us);
      ns_a_node.push_back(least_us * 1e3 / result.visited);
      if (round > 0) continue;
      drawn += result.drawn;
      visited += result.visited;
      triangles += result.triangles;
      lacking += result.refused;
      hash = hash * 0x9e3779b97f4a7c15u + hash_of(ground.view(0));
    }
  }
  const auto frames = static_cast<double>(cameras.size());
  std::printf(
      "%.*s: %.0f nodes of %.0f looked at, %.0f triangles a frame; %.1f lack something; nodes %016llx\n",
      static_cast<int>(name.size()), name.data(), drawn / frames, visited / frames, triangles / frames,
      lacking / frames, static_cast<unsigned long long>(hash));
  std::printf("  a selection %8.1f us median %8.1f us p95 %8.0f ns a node looked at\n", part(us, 0.5),
              part(us, 0.95), part(ns_a_node, 0.5));
  std::printf("  after other work %3.1f us median %8.1f us p95\n", part(cold_us, 0.5), part(cold_us, 0.95));
  return {};
}

}  // namespace karst::bench
