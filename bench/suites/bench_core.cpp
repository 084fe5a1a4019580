// SPDX-License-Identifier: MIT
// Times one thread. Each figure is the median of its rounds; rounds of all figures are interleaved, so that a
// slow minute of the machine hits them alike. The stream-write is memset of the vertices' bytes: what they
// cost to write if they cost nothing to compute.
#include "bench/suites/bench_core.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "app/common/json_writer.h"
#include "app/files/atomic_file.h"
#include "terrain/draw/index_batches.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/world/terrain_parts.h"

namespace karst::bench {
using namespace core;
using namespace app;
namespace {

// K's figures for its test scene at levels 1..5, milliseconds: tables 5.9's columns extraction,
// approximation, shared vertices and normals added up (its last column, indices, is a table here).
constexpr std::array<double, 6> kReferenceMs = {0, 116, 152, 250, 600, 1800};
constexpr std::array<double, 6> kReferenceIndicesMs = {0, 4, 13, 50, 150, 460};

double now_ms() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

struct Series {
  std::vector<double> ms;
  void time(const std::function<void()>& work) {
    const double start = now_ms();
    work();
    ms.push_back(now_ms() - start);
  }
  double median() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
  double least() const { return *std::min_element(ms.begin(), ms.end()); }
};

struct FreeAligned {
  void operator()(std::byte* p) const { std::free(p); }
};
using AlignedMemory = std::unique_ptr<std::byte, FreeAligned>;

AlignedMemory allocate(std::size_t bytes) {
  const std::size_t rounded = (bytes + Arena::kAlignment - 1) / Arena::kAlignment * Arena::kAlignment;
  return AlignedMemory(static_cast<std::byte*>(std::aligned_alloc(Arena::kAlignment, rounded)));
}

struct LevelFigures {
  int level = 0;
  std::size_t vertices = 0;
  Series generate;
  Series stream_write;
};

void print_text(const World& world, const Series& extract, const Series& sky,
                const std::vector<LevelFigures>& levels) {
  const Budget budget = terrain_budget(world.config());
  std::printf("%u patches in %u volumes, %u octets\n", world.patch_count(), world.info().volumes,
              world.info().octets);
  std::printf("extraction and adjacency: median %.2f ms, least %.2f ms\n", extract.median(), extract.least());
  std::printf("sky visibility: %zu bytes, median %.2f ms, least %.2f ms\n", world.sky().grid().bytes(),
              sky.median(), sky.least());
  for (const LevelFigures& l : levels) {
    const double total = extract.median() + l.generate.median();
    std::printf(
        "level %d: %zu vertices, all stages median %.1f ms, least %.1f ms, %.1f ns a vertex, %.1f x "
        "stream-write (%.1f ms)",
        l.level, l.vertices, total, extract.least() + l.generate.least(),
        total * 1e6 / static_cast<double>(l.vertices), total / l.stream_write.median(),
        l.stream_write.median());
    const std::size_t k = static_cast<std::size_t>(l.level);
    if (k < kReferenceMs.size()) std::printf("; K %.0f ms", kReferenceMs[k] + kReferenceIndicesMs[k]);
    std::printf("\n");
  }
  std::printf("index tables: %zu bytes; all levels 1..%d: %zu bytes\n", world.index_table().size_bytes(),
              kMaxLevel, index_count(kMaxLevel) * sizeof(std::uint16_t));
  for (const Budget::Term& term : budget.terms()) {
    if (!term.gpu) std::printf("memory %-14s %10zu bytes\n", term.name, term.bytes);
  }
  std::printf("memory of the core   %10zu bytes = %.2f MiB\n", budget.cpu_bytes(),
              static_cast<double>(budget.cpu_bytes()) / (1 << 20));
}

std::string json_text(const World& world, const Series& extract, const Series& sky,
                      const std::vector<LevelFigures>& levels) {
  const Budget budget = terrain_budget(world.config());
  JsonWriter json;
  json.begin_object();
  json.field("patches", world.patch_count()).field("volumes", world.info().volumes);
  json.field("extract_ms", extract.median()).field("sky_ms", sky.median());
  json.key("levels").begin_array();
  for (const LevelFigures& l : levels) {
    json.begin_object().field("level", l.level).field("vertices", std::uint64_t{l.vertices});
    json.field("all_stages_ms", extract.median() + l.generate.median())
        .field("stream_write_ms", l.stream_write.median());
    json.end_object();
  }
  json.end_array();
  json.field("index_table_bytes", std::uint64_t{index_count(kMaxLevel) * sizeof(std::uint16_t)});
  json.field("core_bytes", std::uint64_t{budget.cpu_bytes()});
  json.end_object();
  return json.text();
}

int fail(const Status& status) {
  std::fprintf(stderr, "karst-bench: %s (%s)\n", status.what(), status.field());
  return 1;
}

}  // namespace

int run_core_suite(std::span<const std::byte> file, const CoreSuiteOptions& options) {
  WorldReader reader;
  if (const Status status = reader.open(ByteSource::of(file)); !status.ok()) return fail(status);
  const WorldInfo& info = reader.info();
  const Config config = World::config_for(info, info.level);
  const std::size_t bytes = terrain_budget(config).cpu_bytes();
  const AlignedMemory memory = allocate(bytes);
  const std::size_t vertex_bytes =
      std::size_t{info.patches} * static_cast<std::size_t>(patch_vertices(info.level)) * sizeof(GpuVertex);
  const AlignedMemory vertex_memory = allocate(vertex_bytes + Arena::kAlignment);
  if (memory == nullptr || vertex_memory == nullptr) {
    std::fprintf(stderr, "karst-bench: no memory for %zu bytes\n", bytes + vertex_bytes);
    return 1;
  }
  TerrainParts parts;
  if (const Status status = parts.create(config, {memory.get(), bytes}); !status.ok()) return fail(status);
  if (const Status status = parts.load(file); !status.ok()) return fail(status);

  std::vector<Volume> volumes(info.volumes);
  std::vector<Patch> patches(info.patches);
  std::vector<std::uint32_t> scratch(ExtractSurface::scratch_size(info.volumes));
  ExtractSurface extract;
  extract.octree = &parts.world.octree();
  extract.extent = info.extent;
  extract.volumes = volumes;
  extract.patches = patches;
  extract.scratch = scratch;

  std::vector<std::uint64_t> sky_words(config.sky_words);
  SkyVisibility sky;
  sky.create(sky_words);

  std::memset(vertex_memory.get(), 1, vertex_bytes);  // page faults are not what is measured
  Series extraction;
  Series sky_series;
  std::vector<LevelFigures> levels;
  for (int level = std::max(1, info.level - 2); level <= info.level; ++level) {
    levels.push_back(
        {level, std::size_t{info.patches} * static_cast<std::size_t>(patch_vertices(level)), {}, {}});
  }
  Status status;
  for (int round = 0; round < options.rounds; ++round) {
    extraction.time([&] {
      ExtractSurface::Result made;
      status = extract.run(made);
    });
    if (!status.ok()) return fail(status);
    sky_series.time([&] { sky.build(*extract.octree, info.extent); });
    for (LevelFigures& l : levels) {
      const std::size_t side_vertices = static_cast<std::size_t>(patch_vertices(l.level));
      GpuVertex* vertices = reinterpret_cast<GpuVertex*>(vertex_memory.get());
      l.generate.time([&] {
        for (PatchId p = 0; p < info.patches && status.ok(); ++p)
          status =
              parts.residency.generate(p, l.level, l.level, {vertices + p * side_vertices, side_vertices});
      });
      if (!status.ok()) return fail(status);
      l.stream_write.time([&] { std::memset(vertex_memory.get(), round, l.vertices * sizeof(GpuVertex)); });
    }
  }
  if (options.json == "-") {
    std::fputs(json_text(parts.world, extraction, sky_series, levels).c_str(), stdout);
    return 0;
  }
  print_text(parts.world, extraction, sky_series, levels);
  if (options.json.empty()) return 0;
  const std::string text = json_text(parts.world, extraction, sky_series, levels);
  if (Error error = write_file_atomic(options.json, std::as_bytes(std::span(text))); !error.ok()) {
    std::fprintf(stderr, "karst-bench: %s\n", error.text().c_str());
    return 1;
  }
  return 0;
}

}  // namespace karst::bench
