// SPDX-License-Identifier: MIT
// karst budget: the limits of a configuration and every byte they cost, before anything is allocated.
#include <algorithm>
#include <cstdio>
#include <string>

#include "app/command_line/command_line.h"
#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/file_source.h"
#include "app/common/json_writer.h"
#include "app/common/status_text.h"
#include "app/options/board_options.h"
#include "app/options/scene_ranges.h"
#include "scene/scene.h"
#include "terrain/draw/index_batches.h"

namespace karst::app {
using namespace core;
namespace {

struct BudgetOptions {
  std::string world;
  std::string board_name;
  BoardProfile board;  // where board_name is not empty
  int level = kMaxLevel;
  int width = 1280;
  int height = 720;
  bool list_boards = false;
  bool json = false;
};

Error store_board(void* options, const OptionValue& value) {
  auto& budget = *static_cast<BudgetOptions*>(options);
  budget.board_name = value.text;
  if (Error error = read_board(value.text, budget.board); !error.ok()) return error;
  budget.level = budget.board.level;
  budget.width = budget.board.width;
  budget.height = budget.board.height;
  return {};
}

Error store_size(void* options, const OptionValue& value) {
  auto& budget = *static_cast<BudgetOptions*>(options);
  budget.width = value.width;
  budget.height = value.height;
  return {};
}

constexpr OptionRow kRows[] = {
    {.name = "board",
     .kind = ValueKind::other,
     .value = "BOARD",
     .help = "a board's limits, by name or those of FILE.board",
     .store = store_board},
    {.name = "list-boards",
     .help = "prints the boards that there are",
     .store = put<&BudgetOptions::list_boards>},
    {.name = "level",
     .kind = ValueKind::integer,
     .value = "N",
     .initial = "the world's",
     .min = 1,
     .max = kMostLevel,
     .help = "finest level of WORLD that is held on the GPU",
     .store = put<&BudgetOptions::level>},
    {.name = "size",
     .kind = ValueKind::size,
     .value = "WxH",
     .initial = "1280x720",
     .max = kMostPicture,
     .help = "of the picture in pixels",
     .store = store_size},
    {.name = "json", .help = "for programs", .store = put<&BudgetOptions::json>},
};
constexpr OptionGroup kGroups[] = {{"options", kRows}};
constexpr OptionPart kParts[] = {kGroups};

Error parse(std::span<const char* const> words, CommandLine& line, BudgetOptions& options) {
  if (Error error = line.parse(words, kBudgetSpec); !error.ok()) return error;
  if (line.wants_help()) return {};
  if (line.positional().size() > 1) return "more than one WORLD";
  if (!line.positional().empty()) options.world = line.positional()[0];
  if (line.has("level") && options.world.empty() && !line.has("board"))
    return "--level needs a WORLD or a --board";
  void* const targets[] = {&options};
  return line.store(targets);
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
    result.config.stream_indices = std::min(result.config.stream_indices,
                                            result.config.max_draw_items * max_patch_indices(options.level));
  }
  result.picture.width = options.width;
  result.picture.height = options.height;
  result.renderer.vertex_pages = result.config.gpu_vertex_pages;
  result.renderer.morph_rows = result.config.max_views * result.config.max_resident_patches;
  result.renderer.stream_indices = result.config.stream_indices;
  result.renderer.extent = glm::ivec3(1 << result.config.max_depth);
  return result;
}

Error world_budget(const BudgetOptions& options, WorldBudget& result) {
  FileSource file;
  if (Error error = file.open(options.world); !error.ok()) return error;
  WorldReader reader;
  if (const Status status = reader.open(file.source()); !status.ok()) {
    return status_text(options.world, status);
  }
  const WorldInfo& info = reader.info();
  const int level = std::min(options.level, info.level);
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
  world.picture.rgb565 = board.rgb565;
  world.renderer.cascades = CascadeSettings().count;
  if (has_board) {
    world.renderer.cascades = board.cascades;
    if (board.cascades > 0) world.renderer.shadow_size = board.cascade_side;
  }
  if (has_board && board.drape_side > 0) {
    world.renderer.drape_width = world.renderer.drape_height = board.drape_side;
  }
  world.add_up();
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
  std::printf("  %d x %d, %s, %d buffers, level %d, %.3g px, pool of %.3g MiB\n", options.width,
              options.height, board.rgb565 ? "16 bits" : "32 bits", board.buffers, options.level,
              board.error_px, static_cast<double>(board.vertex_bytes) / kMiB);
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

constinit const CommandSpec kBudgetSpec = {
    .name = "karst budget",
    .brief = "says what memory a world takes",
    .usage = "[WORLD] [options]",
    .about =
        "Prints every limit with its unit and reason, and the bytes that each part of the program takes for "
        "them: those of the default configuration, or the least that hold WORLD. With a board, everything "
        "is checked against what it has, and the exit code is 1 where it does not fit.",
    .parts = kParts,
    .examples =
        "karst budget\n"
        "karst budget canyon.karst --level 4 --json\n"
        "karst budget canyon.karst --board raspberry-pi-4\n"};

int run_budget(std::span<const char* const> words) {
  CommandLine line;
  BudgetOptions options;
  if (const std::string usage = parse(words, line, options); !usage.empty()) {
    print_error("karst budget", usage);
    return kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(help_text(kBudgetSpec).c_str(), stdout);
    return kExitOk;
  }
  if (options.list_boards) {
    for (const BoardText& board : board_texts()) std::puts(board.name);
    return kExitOk;
  }
  WorldBudget world;
  if (options.world.empty()) {
    world = default_budget(options);
  } else if (const Error error = world_budget(options, world); !error.ok()) {
    print_error("karst budget", error.text());
    return kExitFailure;
  }
  const BoardUse use = add_up(options, world);
  if (options.json) {
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
