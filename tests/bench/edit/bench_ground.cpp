// SPDX-License-Identifier: MIT
// What a dab on heights of a ground costs, in time on a core: in the middle of a node of size 0, over borders
// of four of them, and over nine; all that follows at once, and what is left for later frames.
#include <cmath>
#include <cstdio>
#include <vector>

#include "terrain/base/arena.h"
#include "terrain/edit/ground/edit_ground.h"
#include "tests/bench/bench.h"
#include "tests/support/memory_ground.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

constexpr std::int64_t kSamples = 1'025;
constexpr std::uint32_t kTiles = 200;

int run_ground(bool smoke) {
  const test::MemoryGround ground(kSamples, kSamples, 8'192, 8'192, [](std::int64_t i, std::int64_t k) {
    const double x = static_cast<double>(i), z = static_cast<double>(k);
    return static_cast<std::int32_t>(9'000 * std::sin(0.02 * x) * std::cos(0.03 * z) + 60 * std::sin(x * z));
  });
  test::MemoryGround::Source source(ground);
  Budget budget;
  EditGround::add_to(budget, {kTiles, 0});
  const test::AlignedBytes memory(static_cast<std::size_t>(budget.cpu_bytes()));
  Arena arena(memory.bytes());
  EditGround edits;
  if (!edits.create({kTiles, 0}, arena).ok()) return 1;
  edits.attach(
      ground.info(), ground.tile(tile_of(ground.root())), source.source(),
      {&ground, [](const void* context, NodeKey key, const TilePlace&, std::span<std::byte>, Tile& out) {
         out = static_cast<const test::MemoryGround*>(context)->tile(key);
         return Status();
       }});
  const int repeats = smoke ? 2 : 201;
  const struct {
    const char* name;
    double place, radius;
  } cases[] = {{"within a node", 516, 1.5}, {"over four", 520, 3}, {"over nine", 516, 8}};
  std::printf("dabs on a ground of %lld^2 samples, microseconds of CPU time, medians:\n",
              static_cast<long long>(kSamples));
  for (const auto& [name, place, radius] : cases) {
    Edit edit;
    edit.tool = EditTool::extrude;
    edit.shape = BrushShape::cylinder;
    edit.place = {place, 0, place};
    edit.radius = radius;
    std::vector<double> made, later, longest;
    std::size_t samples = 0;
    for (int n = 0; n < repeats; ++n) {
      edit.strength = n % 2 == 0 ? 0.5 : -0.5;
      GroundChange change;
      double start = bench::cpu_ms();
      if (!edits.apply(edit, nullptr, change).ok() || !change.changed) return 1;
      made.push_back(bench::cpu_ms() - start);
      samples = static_cast<std::size_t>((change.samples.high[0] - change.samples.low[0] + 1) *
                                         (change.samples.high[1] - change.samples.low[1] + 1));
      start = bench::cpu_ms();
      double most = 0;
      while (!edits.is_settled()) {
        const double began = bench::cpu_ms();
        edits.settle_some(change);
        most = std::max(most, bench::cpu_ms() - began);
      }
      later.push_back(bench::cpu_ms() - start);
      longest.push_back(most);
    }
    const auto us = [](std::vector<double> ms) { return 1e3 * bench::times_of(std::move(ms)).median_ms; };
    std::printf("  %-14s %4zu samples; at once %6.1f; later %7.1f (a step %.0f at most)\n", name, samples,
                us(made), us(later), us(longest));
  }
  return 0;
}

const bench::Register kRegister{{"ground_edit", run_ground}};

}  // namespace
}  // namespace karst::core
