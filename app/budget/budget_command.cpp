// SPDX-License-Identifier: MIT
// karst budget: the limits of a configuration and every byte they cost, before anything is allocated.
#include <algorithm>
#include <cstdio>
#include <string>

#include "app/command_line/command_line.h"
#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/common/picture_target.h"
#include "app/files/file_source.h"
#include "app/options/board_options.h"
#include "app/options/scene_ranges.h"
#include "app/stage/stage.h"
#include "karst/plan.h"
#include "platform/base/error.h"

namespace karst::app {
namespace {

struct BudgetOptions {
  std::string world;
  std::string board_name;
  BoardProfile board;  // where board_name is not empty
  int level = kMostLevel;
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

// What the program takes beside karst, and whether a board has it.
struct BudgetUse {
  std::uint64_t target = 0;  // the picture
  std::uint64_t drape = 0;   // the largest image that the board's profile allows
  std::uint64_t cpu = 0;
  std::uint64_t gpu = 0;
  bool fits = true;
};

// The plan, with as many heights as find room on the board.
Error make_budget(const BudgetOptions& options, Plan& plan, BudgetUse& use) {
  const BoardProfile& board = options.board;
  const bool has_board = !options.board_name.empty();
  Needs& needs = plan.needs;
  needs.level = static_cast<std::uint32_t>(options.level);
  needs.query_level = needs.level;
  needs.queries = 1;  // for the ground, as render and view have it
  needs.query_patches = kGroundPatches;
  needs.max_cpu_bytes = needs.max_gpu_bytes = UINT64_MAX;
  if (!has_board || (board.deferred && samples_of(board.antialias) == 1)) {
    needs.deferred_width = static_cast<std::uint32_t>(options.width);
    needs.deferred_height = static_cast<std::uint32_t>(options.height);
  }
  if (has_board) {
    needs.vertex_bytes = board.vertex_bytes;
    needs.shadow_maps = static_cast<std::uint32_t>(board.cascades);
    if (board.cascades > 0) needs.shadow_size = static_cast<std::uint32_t>(board.cascade_side);
    needs.max_cpu_bytes = board.cpu_bytes;
    use.drape = board.drape_bytes();
  }
  Status status;
  if (options.world.empty()) {
    status = make_plan(plan);
  } else {
    FileSource file;
    if (Error error = file.open(options.world); !error.ok()) return error;
    status = make_plan(file.source(), plan);
  }
  // What does not fit is still printed.
  const bool too_large = status.code() == StatusCode::limit_reached && plan.term_count > 0;
  if (!status.ok() && !too_large) return {options.world.empty() ? "the limits" : options.world, status};
  PictureSettings picture;
  picture.width = options.width;
  picture.height = options.height;
  picture.rgb565 = board.rgb565;
  picture.samples = samples_of(board.antialias);
  picture.own_depth = needs.deferred_width == 0;
  use.target = picture.bytes();
  use.cpu = plan.cpu_bytes;
  use.gpu = plan.gpu_bytes + use.target + use.drape;
  if (!has_board) return {};
  use.gpu += board.scan_out_bytes();
  use.fits = status.ok() && use.cpu <= board.cpu_bytes && use.gpu <= board.gpu_bytes;
  return {};
}

// The bytes of one side, by name.
template <class Print>
void each_term(const Plan& plan, const BudgetUse& use, bool gpu, const Print& print) {
  for (std::uint32_t n = 0; n < plan.term_count; ++n) {
    if (plan.terms[n].gpu == gpu) print(plan.terms[n].name, plan.terms[n].bytes);
  }
  if (!gpu) return;
  print("targets", use.target);
  if (use.drape > 0) print("drape", use.drape);
}

std::uint64_t total_of(const Plan& plan, const BudgetUse& use, bool gpu) {
  return gpu ? plan.gpu_bytes + use.target + use.drape : plan.cpu_bytes;
}

void print_json(const BudgetOptions& options, const Plan& plan, const BudgetUse& use) {
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
  for (std::uint32_t n = 0; n < plan.limit_count; ++n) json.field(plan.limits[n].name, plan.limits[n].value);
  json.end_object();
  for (const bool gpu : {false, true}) {
    json.key(gpu ? "gpu_bytes" : "cpu_bytes").begin_object();
    each_term(plan, use, gpu, [&](const char* name, std::uint64_t bytes) { json.field(name, bytes); });
    json.field("total", total_of(plan, use, gpu)).end_object();
  }
  json.end_object();
  std::fputs(json.text().c_str(), stdout);
}

constexpr double kMiB = 1 << 20;

void print_board(const BudgetOptions& options, const BudgetUse& use) {
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

void print_text(const Plan& plan, const BudgetUse& use) {
  std::puts("limit                    value    default  range, unit, reason");
  for (std::uint32_t n = 0; n < plan.limit_count; ++n) {
    const Limit& limit = plan.limits[n];
    std::printf("%-20s %9u %10u  %u..%u %s: %s\n", limit.name, limit.value, limit.standard, limit.least,
                limit.most, limit.unit, limit.reason);
  }
  for (const bool gpu : {false, true}) {
    std::printf("\n%s\n", gpu ? "GPU bytes" : "CPU bytes");
    each_term(plan, use, gpu, [](const char* name, std::uint64_t bytes) {
      std::printf("  %-16s %12llu\n", name, static_cast<unsigned long long>(bytes));
    });
    const std::uint64_t total = total_of(plan, use, gpu);
    std::printf("  %-16s %12llu  (%.2f MiB)\n", "total", static_cast<unsigned long long>(total),
                static_cast<double>(total) / (1 << 20));
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
  if (const Error usage = parse(words, line, options); !usage.ok()) {
    print_error("karst budget", usage.text());
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
  Plan plan;
  BudgetUse use;
  if (const Error error = make_budget(options, plan, use); !error.ok()) {
    print_error("karst budget", error.text());
    return kExitFailure;
  }
  if (options.json) {
    print_json(options, plan, use);
  } else {
    print_text(plan, use);
    if (!options.board_name.empty()) print_board(options, use);
  }
  if (use.fits) return kExitOk;
  print_error("karst budget", "it does not fit " + options.board_name);
  return kExitFailure;
}

}  // namespace karst::app
