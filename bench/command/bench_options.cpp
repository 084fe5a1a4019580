// SPDX-License-Identifier: MIT
#include "bench/command/bench_options.h"

#include "app/common/arguments.h"
#include "app/options/scene_ranges.h"

namespace karst::bench {
namespace {

using namespace app;
using Kind = ValueKind;

// "1,2,4" or "none".
Error parse_list(const OptionValue& value, double min, double max, std::vector<double>& out) {
  out.clear();
  if (value.text == "none") return {};
  for (std::string_view rest = value.text;;) {
    const std::size_t comma = rest.find(',');
    if (Error error = parse_number(rest.substr(0, comma), value.what, min, max, out.emplace_back());
        !error.ok()) {
      return error;
    }
    if (comma == std::string_view::npos) return {};
    rest.remove_prefix(comma + 1);
  }
}

Error store_targets(void* options, const OptionValue& value) {
  return parse_list(value, kLeastErrorTarget, kMostErrorTarget, static_cast<BenchOptions*>(options)->targets);
}

Error store_distances(void* options, const OptionValue& value) {
  return parse_list(value, 0, kMostReach, static_cast<BenchOptions*>(options)->distances);
}

constexpr OptionRow kSuiteRows[] = {
    {.name = "suite",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "core",
     .words = "core lod pareto shading shadows queries flight frames select sweep motion",
     .help =
         "core: extraction, adjacency, vertices and packing of all patches, on one core; lod: choosing, "
         "making and submitting frames of 1, 2 and 4 passes at levels 4 and 5; pareto: frames against their "
         "error, a sweep of error targets and of distances, on flights; shading: nanoseconds a pixel of each "
         "part of shading, on and off, and how pictures differ; shadows: shadow maps that are kept, beside "
         "drawing all in every frame, turning and on flights; queries: rays, heights under wheels, columns, "
         "spheres and picks of voxels on one thread; "
         "flight: nothing, but prints a flight as --path takes it, with the terrain that it shows; "
         "frames: times of frames on three flights, drawn as the options say; "
         "select: choosing levels, listing and writing indices on flights, without GL; "
         "sweep: the same views of synthetic grounds of 10^6 to 10^12 samples; "
         "motion: flights over such a ground, with reading ahead and without; both take no WORLD",
     .store = put<&BenchOptions::suite>},
    {.name = "rounds",
     .kind = Kind::integer,
     .value = "N",
     .initial = "core, queries: 9, shading, select, sweep: 3, pareto: 1",
     .min = 1,
     .max = 1000,
     .help = "medians are over so many rounds; of pareto and select: measured laps (all but lod, shadows and "
             "motion)",
     .store = put<&BenchOptions::rounds>},
    {.name = "frames",
     .kind = Kind::integer,
     .value = "N",
     .initial = "lod, flight, frames, sweep: 24, pareto: 120, shading: 1, shadows: 36, select, motion: 240",
     .min = 1,
     .max = 100000,
     .help = "of each flight (all but core and queries)",
     .store = put<&BenchOptions::frames>},
    {.name = "json",
     .kind = Kind::file,
     .value = "FILE",
     .help = "for programs; - prints it instead of the table (all but shadows, queries, flight, select and "
             "motion)",
     .store = put<&BenchOptions::json>},
    {.name = "version", .help = "prints the version"},
};

constexpr OptionRow kShadingRows[] = {
    {.name = "against",
     .kind = Kind::file,
     .value = "WORLD",
     .help = "the same world baked another way: compares textures, their memory and PSNR too",
     .store = put<&BenchOptions::against>},
};

constexpr OptionRow kParetoRows[] = {
    {.name = "path",
     .kind = Kind::file,
     .value = "FILE",
     .help = "this flight, as of karst render, in place of the standard ones",
     .store = put<&BenchOptions::path_file>},
    {.name = "targets",
     .kind = Kind::other,
     .value = "LIST",
     .initial = "0.25,0.5,1,2,4,8,16",
     .help = "error targets in pixels, or none",
     .store = store_targets},
    {.name = "distances",
     .kind = Kind::other,
     .value = "LIST",
     .initial = "16,32,64,128",
     .help = "of K's scheme, in voxels, or none",
     .store = store_distances},
    {.name = "full", .help = "measures the full level too", .store = put<&BenchOptions::full>},
    {.name = "no-errors", .help = "times and memory alone", .store = put_false<&BenchOptions::errors>},
    {.name = "elevation",
     .kind = Kind::file,
     .value = "PNG",
     .help = "measures errors against this elevation, else against pictures of the full level",
     .store = put<&BenchOptions::elevation>},
    {.name = "pixel-size",
     .kind = Kind::number,
     .value = "M",
     .unit = "metres",
     .min = 1e-4,
     .max = 1e6,
     .help = "of the elevation, as given to karst-bake",
     .store = put<&BenchOptions::pixel_size_m>},
    {.name = "z-scale",
     .kind = Kind::number,
     .value = "S",
     .initial = "1",
     .min = 1e-9,
     .max = 1e9,
     .help = "of the elevation, as given to karst-bake",
     .store = put<&BenchOptions::z_scale>},
    {.name = "csv",
     .kind = Kind::file,
     .value = "FILE",
     .help = "the table",
     .store = put<&BenchOptions::csv>},
    {.name = "svg",
     .kind = Kind::file,
     .value = "FILE",
     .help = "plots of it",
     .store = put<&BenchOptions::svg>},
    {.name = "peers",
     .kind = Kind::file,
     .value = "CSV",
     .help = "other programs' results, drawn beside ours (docs/run-time-against-error.md)",
     .store = put<&BenchOptions::peers>},
};

constexpr OptionRow kQueryRows[] = {
    {.name = "query-level",
     .kind = Kind::integer,
     .value = "K",
     .initial = "3",
     .min = 1,
     .max = 6,
     .help = "of the surface that is asked",
     .store = put<&BenchOptions::query_level>},
    {.name = "query-patches",
     .kind = Kind::integer,
     .value = "N",
     .initial = "all",
     .min = 1,
     .max = 16777216,
     .help = "that are kept ready",
     .store = put<&BenchOptions::query_patches>},
    {.name = "rays",
     .kind = Kind::integer,
     .value = "N",
     .initial = "65536",
     .min = 1024,
     .max = 16777216,
     .help = "of a batch",
     .store = put<&BenchOptions::rays>},
};

constexpr OptionRow kFlightRows[] = {
    {.name = "flight",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "default",
     .words = "default low oblique high teleport",
     .help = "default: the whole world is shown, as without --camera; else a standard flight",
     .store = put<&BenchOptions::flight>},
};

constexpr OptionRow kFramesRows[] = {
    {.name = "gl-times",
     .help = "prints what the functions of GL take, each by the clock",
     .store = put<&BenchOptions::gl_times>},
};

constexpr OptionRow kSweepRows[] = {
    {.name = "jumps",
     .kind = Kind::integer,
     .value = "N",
     .initial = "8",
     .min = 1,
     .max = 1000,
     .help = "to new places of each ground",
     .store = put<&BenchOptions::jumps>},
    {.name = "disk-speed",
     .kind = Kind::number,
     .value = "MB",
     .initial = "100, motion: 20",
     .unit = "megabytes a second",
     .min = 0.01,
     .max = 1e6,
     .help = "of what tiles are read from",
     .store = put<&BenchOptions::disk_mb_per_s>},
    {.name = "disk-seek",
     .kind = Kind::number,
     .value = "MS",
     .initial = "5, motion: 8",
     .unit = "milliseconds",
     .min = 0,
     .max = 1e4,
     .help = "before each tile",
     .store = put<&BenchOptions::disk_seek_ms>},
    {.name = "disk-sleep",
     .kind = Kind::number,
     .value = "MS",
     .initial = "1000",
     .unit = "milliseconds",
     .min = 1,
     .max = 1e5,
     .help = "of a disk that no frame may wait for, before each tile",
     .store = put<&BenchOptions::disk_sleep_ms>},
};

constexpr OptionGroup kGroups[] = {{"suite", kSuiteRows},      {"of shading", kShadingRows},
                                   {"of pareto", kParetoRows}, {"of queries", kQueryRows},
                                   {"of flight", kFlightRows}, {"of frames", kFramesRows},
                                   {"of sweep", kSweepRows}};
constexpr OptionPart kParts[] = {kGroups, kSceneGroups};

// What a suite has no use for, with blanks around each: it draws nothing, or the option is what it varies.
constexpr const char* kUnused[] = {
    // core
    " gl-times frames against path targets distances full no-errors elevation pixel-size z-scale csv svg "
    "peers board "
    "size "
    "sun fov haze show precision no-skip lod error-px lod-distance level generate-ms vertex-memory "
    "max-memory "
    "shadows shadow-size shadow-reach drape drape-repeat query-level query-patches rays flight jumps "
    "disk-speed disk-seek disk-sleep ",
    // lod
    " gl-times rounds against path targets distances full no-errors elevation pixel-size z-scale csv svg "
    "peers level "
    "generate-ms query-level query-patches rays flight jumps disk-speed disk-seek disk-sleep ",
    // pareto
    " gl-times against lod error-px lod-distance query-level query-patches rays flight jumps disk-speed "
    "disk-seek "
    "disk-sleep ",
    // shading
    " gl-times path targets distances full no-errors elevation pixel-size z-scale csv svg peers precision "
    "no-skip "
    "generate-ms query-level query-patches rays flight jumps disk-speed disk-seek disk-sleep ",
    // shadows
    " gl-times rounds json against path targets distances full no-errors elevation pixel-size z-scale csv "
    "svg peers "
    "generate-ms drape drape-repeat query-level query-patches rays flight jumps disk-speed disk-seek "
    "disk-sleep ",
    // queries
    " gl-times frames json against path targets distances full no-errors elevation pixel-size z-scale csv "
    "svg peers "
    "board size sun fov haze show precision no-skip lod error-px lod-distance level generate-ms "
    "vertex-memory max-memory shadows shadow-size shadow-reach drape drape-repeat flight jumps disk-speed "
    "disk-seek disk-sleep ",
    // flight
    " gl-times rounds json against path targets distances full no-errors elevation pixel-size z-scale csv "
    "svg peers "
    "generate-ms query-level query-patches rays jumps disk-speed disk-seek disk-sleep ",
    // frames
    " rounds against path targets distances full no-errors elevation pixel-size z-scale csv svg peers "
    "generate-ms query-level query-patches rays flight jumps disk-speed disk-seek disk-sleep ",
    // select
    " gl-times json against path targets distances full no-errors elevation pixel-size z-scale csv svg peers "
    "sun haze "
    "show precision drape drape-repeat query-level query-patches rays flight jumps disk-speed disk-seek "
    "disk-sleep ",
    // sweep
    " gl-times against path targets distances full no-errors elevation pixel-size z-scale csv svg peers "
    "lod-distance "
    "level generate-ms drape drape-repeat query-level query-patches rays flight ",
    // motion
    " gl-times rounds json against path targets distances full no-errors elevation pixel-size z-scale csv "
    "svg "
    "peers lod-distance level generate-ms drape drape-repeat query-level query-patches rays flight jumps "
    "disk-sleep "};
constexpr const char* kSuiteNames[] = {"core",   "lod",    "pareto", "shading", "shadows", "queries",
                                       "flight", "frames", "select", "sweep",   "motion"};

Error check(const CommandLine& line, const BenchOptions& options) {
  const auto suite = static_cast<std::size_t>(options.suite);
  Error error;
  for_each_option(kBenchSpec, [&](const OptionRow& row) {
    if (!line.has(row.name) || !error.ok()) return;
    const std::string name = std::string(1, ' ').append(row.name).append(" ");
    if (std::string_view(kUnused[suite]).find(name) != std::string_view::npos) {
      error = std::string("--") + row.name + ": the suite " + kSuiteNames[suite] + " has no use for it";
    }
  });
  if (!error.ok()) return error;
  if (!options.elevation.empty() && options.pixel_size_m == 0) return "--elevation: needs --pixel-size";
  if (options.targets.empty() && options.distances.empty() && !options.full) return "nothing to measure";
  if (options.suite == SuiteName::shadows && options.scene.shadows == 0)
    return "nothing to measure: there are no shadow maps";
  return check_scene(options.scene, line.has("drape-repeat"));
}

}  // namespace

constinit const CommandSpec kBenchSpec = {
    .name = "karst-bench",
    .brief = "measures what worlds and frames cost",
    .usage = "WORLD [--suite NAME] [options]\n--suite sweep|motion [options]",
    .about =
        "Measures a world and prints the results beside those of the paper it follows. Each suite refuses "
        "the options that it has no use for. In lod, pareto, sweep and motion there are no shadow maps "
        "unless "
        "--shadows or "
        "--board says so; lod and shading keep everything resident unless --vertex-memory or --board says "
        "otherwise.",
    .parts = kParts,
    .examples =
        "karst-bench canyon.karst\n"
        "karst-bench canyon.karst --suite pareto --csv canyon.csv --svg canyon.svg\n"
        "karst-bench --suite sweep\n"};

Error parse_bench_options(std::span<const char* const> words, CommandLine& line, BenchOptions& options) {
  if (Error error = line.parse(words, kBenchSpec); !error.ok()) return error;
  if (line.wants_help() || line.has("version")) return {};
  void* const targets[] = {&options, &options.scene};
  if (Error error = line.store(targets); !error.ok()) return error;
  const bool sweeps = options.suite == SuiteName::sweep || options.suite == SuiteName::motion;
  if (sweeps && !line.positional().empty())
    return "the suites sweep and motion make their own grounds: they take no WORLD";
  if (!sweeps && line.positional().size() != 1) return "takes one WORLD";
  if (!sweeps) options.world = line.positional()[0];
  const bool levels_alone = sweeps || options.suite == SuiteName::lod || options.suite == SuiteName::pareto;
  if (levels_alone && !line.has("shadows") && !line.has("board")) options.scene.shadows = 0;
  return check(line, options);
}

}  // namespace karst::bench
