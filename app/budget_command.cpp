// SPDX-License-Identifier: MIT
// karst budget: the limits of a configuration and every byte they cost, before anything is allocated.
#include <algorithm>
#include <cstdio>
#include <string>

#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/common/mapped_file.h"
#include "app/scene.h"
#include "app/status_text.h"

namespace karst::app {
namespace {

constexpr const char* kHelp =
    R"(usage: karst budget [WORLD] [--level N] [--size WxH] [--json]

Prints every limit with its unit and reason, and the bytes that each part of the program takes for them: those
of the default configuration, or the least that hold WORLD.

      --level N     finest level of WORLD that is held on the GPU, 1 to 6 (the world's)
      --size WxH    of the picture in pixels (1280x720)
      --json        for programs

  karst budget
  karst budget canyon.karst --level 4 --json
)";

constexpr Option kOptions[] = {{"level"}, {"size"}, {"json", 0, false}, {"help", 'h', false}};

struct BudgetOptions {
  std::string world;
  std::int64_t level = kMaxLevel;
  int width = 1280;
  int height = 720;
};

std::string parse(std::span<const char* const> words, Arguments& arguments, BudgetOptions& options) {
  if (std::string error = arguments.parse(words, kOptions); !error.empty()) return error;
  if (arguments.has("help")) return {};
  if (arguments.positional().size() > 1) return "more than one WORLD";
  if (!arguments.positional().empty()) options.world = arguments.positional()[0];
  std::string error;
  if (const auto text = arguments.value("level")) {
    if (options.world.empty()) return "--level needs a WORLD";
    error = parse_integer(*text, "--level", 1, kMaxLevel, options.level);
  }
  if (const auto text = arguments.value("size"); text && error.empty()) {
    error = parse_size(*text, "--size", RendererSettings::kMaxPicture, options.width, options.height);
  }
  return error;
}

WorldBudget default_budget(const BudgetOptions& options) {
  WorldBudget result;
  result.renderer.width = options.width;
  result.renderer.height = options.height;
  result.renderer.vertex_pages = result.config.gpu_vertex_pages;
  result.renderer.morph_rows = result.config.max_resident_patches;
  result.renderer.stream_indices = result.config.stream_indices;
  result.renderer.extent = glm::ivec3(1 << result.config.max_depth);
  result.budget = Terrain::budget(result.config);
  result.renderer.add_to(result.budget);
  return result;
}

std::string world_budget(const BudgetOptions& options, WorldBudget& result) {
  MappedFile file;
  if (std::string error = file.open(options.world); !error.empty()) return error;
  WorldInfo info;
  if (const Status status = read_world_info(file.bytes(), info); !status.ok()) {
    return status_text(options.world, status);
  }
  const int level = std::min(static_cast<int>(options.level), info.level);
  result = budget_of(info, level, options.width, options.height);
  return {};
}

void print_json(const WorldBudget& world) {
  JsonWriter json;
  json.begin_object().key("config").begin_object();
  for (const ConfigField& field : kConfigFields) json.field(field.name, world.config.*field.member);
  json.end_object();
  for (const bool gpu : {false, true}) {
    json.key(gpu ? "gpu_bytes" : "cpu_bytes").begin_object();
    for (const Budget::Term& term : world.budget.terms()) {
      if (term.gpu == gpu) json.field(term.name, std::uint64_t{term.bytes});
    }
    json.field("total", std::uint64_t{gpu ? world.budget.gpu_bytes() : world.budget.cpu_bytes()})
        .end_object();
  }
  json.end_object();
  std::fputs(json.text().c_str(), stdout);
}

void print_text(const WorldBudget& world) {
  std::puts("limit                    value    default  range, unit, reason");
  for (const ConfigField& field : kConfigFields) {
    std::printf("%-18s %11u %10u  %u..%u %s: %s\n", field.name, world.config.*field.member,
                field.default_value, field.min, field.max, field.unit, field.reason);
  }
  for (const bool gpu : {false, true}) {
    std::printf("\n%s\n", gpu ? "GPU bytes" : "CPU bytes");
    for (const Budget::Term& term : world.budget.terms()) {
      if (term.gpu == gpu) std::printf("  %-16s %12zu\n", term.name, term.bytes);
    }
    const std::size_t total = gpu ? world.budget.gpu_bytes() : world.budget.cpu_bytes();
    std::printf("  %-16s %12zu  (%.2f MiB)\n", "total", total, static_cast<double>(total) / (1 << 20));
  }
}

}  // namespace

int run_budget(std::span<const char* const> words) {
  Arguments arguments;
  BudgetOptions options;
  if (const std::string usage = parse(words, arguments, options); !usage.empty()) {
    print_error("karst budget", usage);
    return kExitUsage;
  }
  if (arguments.has("help")) {
    std::fputs(kHelp, stdout);
    return kExitOk;
  }
  WorldBudget world;
  if (options.world.empty()) {
    world = default_budget(options);
  } else if (const std::string error = world_budget(options, world); !error.empty()) {
    print_error("karst budget", error);
    return kExitFailure;
  }
  arguments.has("json") ? print_json(world) : print_text(world);
  return kExitOk;
}

}  // namespace karst::app
