// SPDX-License-Identifier: MIT
// karst-bench: what a world costs.
#include "bench/suites/bench_command.h"

#include <cstdio>
#include <string>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/mapped_file.h"
#include "app/common/status_text.h"
#include "bench/suites/bench_core.h"
#include "bench/suites/bench_lod.h"
#include "bench/suites/bench_pareto.h"
#include "bench/suites/bench_shading.h"
#include "bench/suites/bench_shadows.h"
#include "terrain/file/world_reader.h"

namespace karst::bench {
using namespace core;
using namespace app;
namespace {

constexpr const char* kHelp =
    R"(usage: karst-bench WORLD [--suite NAME] [options]

Measures a world and prints the results beside those of the paper it follows.

      --suite core      extraction, adjacency, vertices and packing of all patches, on one core (the default)
      --suite lod       choosing, making and submitting frames of 1, 2 and 4 passes at levels 4 and 5
      --suite pareto    frames against their error: a sweep of error targets and of distances, on flights
      --suite shading   nanoseconds a pixel of each part of shading, on and off, and how pictures differ
      --suite shadows   shadow maps that are kept, beside drawing all in every frame: turning and on flights
      --rounds N        medians are over so many rounds, 1 to 1000 (core: 9, shading: 3); pareto: measured
                        laps (1)
      --json FILE       for programs; - prints it instead of the table (core, lod, shading)

Of shading:
      --against WORLD   the same world baked another way: compares textures, their memory and PSNR too

Of lod, pareto, shading and shadows:
      --frames N        of each flight, 1 to 100000 (lod: 24, pareto: 120, shading: 1, shadows: 36)
      --size WxH        of the pictures in pixels (1280x720)
      --drape IMAGE.png, --drape-repeat N
                        one image in place of the materials, as of karst render
      --vertex-memory MIB, --max-memory MIB
                        as of karst render; lod and shading keep everything resident where they are not told
                        otherwise

Of pareto:
      --path FILE       this flight, as of karst render, in place of the standard ones
      --targets LIST    error targets in pixels (0.25,0.5,1,2,4,8,16)
      --distances LIST  of K's scheme, in voxels (16,32,64,128); either list may be 'none'
      --full            measures the full level too
      --no-errors       times and memory alone
      --elevation PNG   measures errors against this elevation, else against pictures of the full level
      --pixel-size M, --z-scale S
                        of the elevation, as given to karst-bake
      --generate-ms MS  as of karst render; errors are always of complete frames
      --csv FILE        the table
      --svg FILE        plots of it
      --peers CSV       other programs' results, drawn beside ours (docs/run-time-against-error.md)

  karst-bench canyon.karst
  karst-bench canyon.karst --suite pareto --csv canyon.csv --svg canyon.svg
)";

constexpr Option kOptions[] = {{"suite"},
                               {"rounds"},
                               {"json"},
                               {"path"},
                               {"frames"},
                               {"size"},
                               {"targets"},
                               {"distances"},
                               {"full", 0, false},
                               {"no-errors", 0, false},
                               {"elevation"},
                               {"pixel-size"},
                               {"z-scale"},
                               {"drape"},
                               {"drape-repeat"},
                               {"generate-ms"},
                               {"vertex-memory"},
                               {"max-memory"},
                               {"csv"},
                               {"svg"},
                               {"peers"},
                               {"against"},
                               {"help", 'h', false}};

struct Command {
  enum class Suite { core, lod, pareto, shading, shadows } suite = Suite::core;
  CoreSuiteOptions core;
  LodSuiteOptions lod;
  ParetoOptions pareto;
  ShadingSuiteOptions shading;
  ShadowSuiteOptions shadows;
};

// "1,2,4" or "none".
std::string parse_list(const Arguments& arguments, const char* name, double min, double max,
                       std::vector<double>& out) {
  const auto given = arguments.value(name);
  if (!given) return {};
  out.clear();
  if (*given == "none") return {};
  for (std::string_view rest = *given;;) {
    const std::size_t comma = rest.find(',');
    if (std::string error =
            parse_number(rest.substr(0, comma), std::string("--") + name, min, max, out.emplace_back());
        !error.empty()) {
      return error;
    }
    if (comma == std::string_view::npos) return {};
    rest.remove_prefix(comma + 1);
  }
}

// Takes the options one by one; the first that is wrong is what error() tells.
class Reader {
 public:
  explicit Reader(const Arguments& arguments) : arguments_(arguments) {}

  std::string text(const char* name) const { return std::string(arguments_.value(name).value_or("")); }
  std::int64_t integer(const char* name, std::int64_t max, std::int64_t otherwise) {
    if (const auto given = arguments_.value(name); given && error.empty()) {
      error = parse_integer(*given, std::string("--") + name, 1, max, otherwise);
    }
    return otherwise;
  }
  double number(const char* name, double min, double max, double otherwise) {
    if (const auto given = arguments_.value(name); given && error.empty()) {
      error = parse_number(*given, std::string("--") + name, min, max, otherwise);
    }
    return otherwise;
  }
  void list(const char* name, double min, double max, std::vector<double>& out) {
    if (error.empty()) error = parse_list(arguments_, name, min, max, out);
  }
  void scene(SceneOptions& options) {
    options.world = arguments_.positional()[0];
    options.shadows.count = 0;  // what is measured is levels of detail
    options.drape = text("drape");
    options.drape_repeat = number("drape-repeat", 0x1p-10, 0x1p10, options.drape_repeat);
    options.vertex_bytes = static_cast<std::uint64_t>(number("vertex-memory", 0, 1024, 0) * (1 << 20));
    options.max_memory = static_cast<std::uint64_t>(integer("max-memory", 1 << 20, 512)) << 20;
    if (const auto given = arguments_.value("size"); given && error.empty()) {
      error = parse_size(*given, "--size", RendererSettings::kMaxPicture, options.width, options.height);
    }
  }

  std::string error;

 private:
  const Arguments& arguments_;
};

std::string parse_pareto(const Arguments& arguments, ParetoOptions& options) {
  Reader reader(arguments);
  reader.scene(options.scene);
  options.path_file = reader.text("path");
  options.elevation = reader.text("elevation");
  options.csv = reader.text("csv");
  options.svg = reader.text("svg");
  options.json = reader.text("json");
  options.peers = reader.text("peers");
  options.full = arguments.has("full");
  options.errors = !arguments.has("no-errors");
  options.targets = {0.25, 0.5, 1, 2, 4, 8, 16};
  options.distances = {16, 32, 64, 128};
  options.rounds = static_cast<int>(reader.integer("rounds", 1000, options.rounds));
  options.frames = static_cast<int>(reader.integer("frames", 100'000, options.frames));
  reader.list("targets", kLeastErrorPx, kMostErrorPx, options.targets);
  reader.list("distances", 0, kCameraReach, options.distances);
  options.pixel_size_m = reader.number("pixel-size", 1e-4, 1e6, options.pixel_size_m);
  options.z_scale = reader.number("z-scale", 1e-9, 1e9, options.z_scale);
  options.generate_ms = reader.number("generate-ms", 0, 1e6, options.generate_ms);
  if (!reader.error.empty()) return reader.error;
  if (!options.elevation.empty() && options.pixel_size_m == 0) return "--elevation: needs --pixel-size";
  if (options.targets.empty() && options.distances.empty() && !options.full) return "nothing to measure";
  return {};
}

std::string parse_shading(const Arguments& arguments, ShadingSuiteOptions& options) {
  const CascadeSettings shadows = options.scene.shadows;
  Reader reader(arguments);
  reader.scene(options.scene);
  options.scene.shadows = shadows;
  options.frames = static_cast<int>(reader.integer("frames", 100'000, options.frames));
  options.rounds = static_cast<int>(reader.integer("rounds", 1000, options.rounds));
  options.against = reader.text("against");
  options.json = reader.text("json");
  return reader.error;
}

// What a wrong command line is told; empty where it is right.
std::string parse(std::span<const char* const> words, Arguments& arguments, Command& command) {
  if (std::string error = arguments.parse(words, kOptions); !error.empty()) return error;
  if (arguments.has("help")) return {};
  if (arguments.positional().size() != 1) return "takes one WORLD";
  const auto suite = arguments.value("suite").value_or("core");
  if (suite == "pareto") {
    command.suite = Command::Suite::pareto;
    return parse_pareto(arguments, command.pareto);
  }
  Reader reader(arguments);
  if (suite == "lod") {
    command.suite = Command::Suite::lod;
    reader.scene(command.lod.scene);
    command.lod.frames = static_cast<int>(reader.integer("frames", 100'000, command.lod.frames));
    command.lod.json = reader.text("json");
    return reader.error;
  }
  if (suite == "shading") {
    command.suite = Command::Suite::shading;
    return parse_shading(arguments, command.shading);
  }
  if (suite == "shadows") {
    command.suite = Command::Suite::shadows;
    reader.scene(command.shadows.scene);
    command.shadows.scene.shadows = {};
    command.shadows.frames = static_cast<int>(reader.integer("frames", 100'000, command.shadows.frames));
    return reader.error;
  }
  if (suite != "core") {
    return "--suite: '" + std::string(suite) + "' is not core, lod, pareto, shading or shadows";
  }
  command.core.rounds = static_cast<int>(reader.integer("rounds", 1000, command.core.rounds));
  command.core.json = reader.text("json");
  return reader.error;
}

int run_core(const std::string& path, const CoreSuiteOptions& options) {
  MappedFile file;
  std::string error = file.open(path);
  if (error.empty()) {
    WorldReader reader;
    Status status = reader.open(ByteSource::of(file.bytes()));
    if (status.ok()) status = reader.verify();
    if (!status.ok()) error = status_text(path, status);
  }
  if (!error.empty()) {
    print_error("karst-bench", error);
    return kExitFailure;
  }
  return run_core_suite(file.bytes(), options);
}

}  // namespace

int run_bench(std::span<const char* const> words) {
  Arguments arguments;
  Command command;
  if (const std::string usage = parse(words, arguments, command); !usage.empty()) {
    print_error("karst-bench", usage);
    return kExitUsage;
  }
  if (arguments.has("help")) {
    std::fputs(kHelp, stdout);
    return kExitOk;
  }
  if (command.suite == Command::Suite::pareto) return run_pareto_suite(command.pareto);
  if (command.suite == Command::Suite::shading) return run_shading_suite(command.shading);
  if (command.suite == Command::Suite::lod) return run_lod_suite(command.lod);
  if (command.suite == Command::Suite::shadows) return run_shadow_suite(command.shadows);
  return run_core(std::string(arguments.positional()[0]), command.core);
}

}  // namespace karst::bench
