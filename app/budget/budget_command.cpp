// SPDX-License-Identifier: MIT
// karst budget: the limits of a configuration and every byte they cost, before anything is allocated.
#include <algorithm>
#include <cstdio>
#include <string>

#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/file_source.h"
#include "app/common/json_writer.h"
#include "app/common/status_text.h"
#include "app/options/board_options.h"
#include "scene/scene.h"
#include "terrain/draw/index_batches.h"

namespace karst::app {
using namespace core;
namespace {

constexpr const char* kHelp =
    R"(usage: karst budget [WORLD] [--board NAME] [--level N] [--size WxH] [--json]

Prints every limit with its unit and reason, and the bytes that each part of the program takes for them: those
of the default configuration, or the least that hold WORLD. With a board, everything is checked against what
it has, and the exit code is 1 where it does not fit.

      --board NAME  a board's limits (see --list-boards), or those of FILE.board
      --list-boards prints the boards that there are
      --level N     finest level of WORLD that is held on the GPU, 1 to 6 (the world's)
      --size WxH    of the picture in pixels (1280x720)
      --json        for programs

  karst budget
  karst budget canyon.karst --level 4 --json
  karst budget canyon.karst --board raspberry-pi-4
)";

constexpr Option kOptions[] = {{"board"}, {"list-boards", 0, false}, {"level"},
                               {"size"},  {"json", 0, false},        {"help", 'h', false}};

struct BudgetOptions {
  std::string world;
  std::string board_name;
  BoardProfile board;  // where board_name is not empty
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
  if (const auto text = arguments.value("board")) {
    options.board_name = *text;
    if (error = read_board(*text, options.board); !error.empty()) return error;
    options.level = options.board.level;
    options.width = options.board.width;
    options.height = options.board.height;
  }
  if (const auto text = arguments.value("level")) {
    if (options.world.empty() && options.board_name.empty()) return "--level needs a WORLD or a --board";
    error = parse_integer(*text, "--level", 1, kMaxLevel, options.level);
  }
  if (const auto text = arguments.value("size"); text && error.empty()) {
    error = parse_size(*text, "--size", RendererSettings::kMaxPicture, options.width, options.height);
  }
  return error;
}

WorldBudget default_budget(const BudgetOptions& options) {
  WorldBudget result;
  if (!options.board_name.empty()) {
    result.config.max_level = static_cast<std::uint32_t>(options.level);
    result.config.gpu_vertex_pages =
        static_cast<std::uint32_t>(options.board.vertex_bytes / (kPageVertices * sizeof(GpuVertex)));
    result.config.max_draw_items = std::min(result.config.max_draw_items, result.config.gpu_vertex_pages);
    result.config.max_resident_patches =
        std::min(result.config.max_resident_patches, result.config.max_draw_items);
    result.config.stream_indices =
        std::min(result.config.stream_indices,
                 result.config.max_draw_items * max_patch_indices(static_cast<int>(options.level)));
  }
  result.renderer.width = options.width;
  result.renderer.height = options.height;
  result.renderer.vertex_pages = result.config.gpu_vertex_pages;
  result.renderer.morph_rows = result.config.max_resident_patches;
  result.renderer.stream_indices = result.config.stream_indices;
  result.renderer.extent = glm::ivec3(1 << result.config.max_depth);
  return result;
}

std::string world_budget(const BudgetOptions& options, WorldBudget& result) {
  FileSource file;
  if (std::string error = file.open(options.world); !error.empty()) return error;
  WorldReader reader;
  if (const Status status = reader.open(file.source()); !status.ok()) {
    return status_text(options.world, status);
  }
  const WorldInfo& info = reader.info();
  const int level = std::min(static_cast<int>(options.level), info.level);
  result = budget_of(info, level, options.width, options.height, options.board.vertex_bytes);
  result.renderer.material_count = reader.materials().count;
  result.renderer.material_side = reader.materials().side;
  result.renderer.material_format = reader.materials().format;
  return {};
}

// What a board has beside the scene: the largest image that its profile allows, and what the screen shows.
struct BoardUse {
  std::uint64_t cpu = 0;
  std::uint64_t gpu = 0;
  bool fits = true;
};

// Completes the budget: by the profile's colour and drape, and with the heights that find room.
BoardUse add_up(const BudgetOptions& options, WorldBudget& world) {
  const BoardProfile& board = options.board;
  const bool has_board = !options.board_name.empty();
  world.renderer.rgb565 = board.rgb565;
  world.renderer.cascades = CascadeSettings().count;
  if (has_board) {
    world.renderer.cascades = board.cascades;
    if (board.cascades > 0) world.renderer.shadow_size = board.cascade_side;
  }
  if (has_board && board.drape_side > 0) {
    world.renderer.drape_width = world.renderer.drape_height = board.drape_side;
  }
  world.budget = Terrain::budget(world.config);
  world.renderer.add_to(world.budget);
  if (has_board) fit_heights(world, board.cpu_bytes + world.budget.gpu_bytes());
  BoardUse use{world.budget.cpu_bytes(), world.budget.gpu_bytes(), true};
  if (!has_board) return use;
  use.gpu += board.scan_out_bytes();
  use.fits = use.cpu <= board.cpu_bytes && use.gpu <= board.gpu_bytes && world.config.validate().ok();
  return use;
}

void print_json(const BudgetOptions& options, const WorldBudget& world, const BoardUse& use) {
  JsonWriter json;
  json.begin_object();
  if (!options.board_name.empty()) {
    const BoardProfile& board = options.board;
    json.key("board").begin_object().field("name", std::string_view(options.board_name));
    json.field("cpu_bytes", board.cpu_bytes).field("gpu_bytes", board.gpu_bytes);
    json.field("scan_out", board.scan_out_bytes()).field("cascades", board.cascade_bytes());
    json.field("cpu_used", use.cpu).field("gpu_used", use.gpu).field("fits", use.fits).end_object();
  }
  json.key("config").begin_object();
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

constexpr double kMiB = 1 << 20;

void print_board(const BudgetOptions& options, const BoardUse& use) {
  const BoardProfile& board = options.board;
  const auto line = [](const char* name, std::uint64_t bytes) {
    std::printf("  %-16s %12llu\n", name, static_cast<unsigned long long>(bytes));
  };
  std::printf("\n%s: %s, %s\n", options.board_name.c_str(), board.title.c_str(), board.driver.c_str());
  std::printf("  %d x %d, %s, %d buffers, level %lld, %.3g px, pool of %.3g MiB\n", options.width,
              options.height, board.rgb565 ? "16 bits" : "32 bits", board.buffers,
              static_cast<long long>(options.level), board.error_px,
              static_cast<double>(board.vertex_bytes) / kMiB);
  line("scan_out", board.scan_out_bytes());
  line("cascades", board.cascade_bytes());
  const auto check = [](const char* name, std::uint64_t used, std::uint64_t limit) {
    std::printf("  %s: %.2f of %.2f MiB, %s\n", name, static_cast<double>(used) / kMiB,
                static_cast<double>(limit) / kMiB, used <= limit ? "fits" : "DOES NOT FIT");
  };
  check("CPU", use.cpu, board.cpu_bytes);
  check("GPU", use.gpu, board.gpu_bytes);
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
  if (arguments.has("list-boards")) {
    for (const BoardText& board : board_texts()) std::puts(board.name);
    return kExitOk;
  }
  WorldBudget world;
  if (options.world.empty()) {
    world = default_budget(options);
  } else if (const std::string error = world_budget(options, world); !error.empty()) {
    print_error("karst budget", error);
    return kExitFailure;
  }
  const BoardUse use = add_up(options, world);
  if (arguments.has("json")) {
    print_json(options, world, use);
  } else {
    print_text(world);
    if (!options.board_name.empty()) print_board(options, use);
  }
  if (use.fits) return kExitOk;
  const Status status = world.config.validate();
  std::string reason = status.ok() ? "" : status_text(": the limits", status);
  print_error("karst budget", "it does not fit " + options.board_name + reason);
  return kExitFailure;
}

}  // namespace karst::app
