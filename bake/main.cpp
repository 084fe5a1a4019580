// SPDX-License-Identifier: MIT
// karst-bake: elevation images and procedural samples to world files.
#include "app/common/arguments.h"
#include "app/common/atomic_file.h"
#include "app/common/progress.h"
#include "bake/base/bake_error.h"
#include "bake/pipeline/bake.h"
#include "bake/pipeline/report.h"
#include "bake/samples/samples.h"
#include "terrain/base/lattice.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <memory>
#include <new>
#include <thread>

namespace karst::bake {
using namespace core;
namespace {

constexpr int kMaxThreads = 256;

constexpr const char* kHelp =
    R"(karst-bake: makes a .karst world from an elevation image or a procedural sample

  karst-bake DEM -o WORLD.karst [options]
  karst-bake --sample NAME -o WORLD.karst [options]

DEM is a TIFF or GeoTIFF, PNG or OpenEXR image of one channel, 16-bit or float, or a raw ENVI file with its
.hdr beside it. Heights are metres. North is up in the image and -z in the world, whose x = z = 0 is the
image's centre.

  -o, --output FILE    the world file; written whole or not at all
      --sample NAME    a procedural world instead of a DEM:
)";

constexpr const char* kHelpOptions = R"(
      --voxel M        size of a voxel in metres (default: about 128 voxels across; samples: 8 or 10)
      --levels K       level of the heights, 1 to 6: 2^K + 1 a patch side (default: vertices 3/4 of a sample
                       apart; samples: 5)
      --pixel-size M   metres between samples, for images that do not say, or say it wrong
      --z-scale S      multiplies heights (default 1)
      --nodata LIST    how voids are known and what becomes of them: any of a value, `fill` (from around,
                       the default) and `hole` (left out), with commas: --nodata -9999,hole
      --crop X,Z,W,H   only these samples: first column, first row, columns, rows
      --allow-8bit     takes 8-bit images, whose heights are steps
      --carve FILE     fills or empties boxes, spheres and tunnels (docs/formats.md)
      --materials FILE what the ground is made of, painted boxes, lights (docs/materials.md); `none`: nothing
      --material-side N    texels of a texture's side: 16, 32, .. 1024 (default 256)
      --material-format F  of textures: etc2 or rgba8 (default etc2)
      --threads N      default: all; the world does not depend on it
      --stats FILE     writes the report as JSON
      --json           prints the report as JSON
      --quiet          prints no report and no progress
      --help

Examples:
  karst-bake dem.tif -o world.karst --voxel 256 --levels 4
  karst-bake srtm.bil -o world.karst --nodata -9999,hole
  karst-bake height.png -o world.karst --pixel-size 2 --z-scale 0.01
  karst-bake --sample canyon -o canyon.karst --json

Exit code: 0 done, 1 a file is not as it must be, 2 the command line is wrong.
)";

struct CommandLine {
  Bake job;
  std::string output;
  std::string stats;
  bool json = false;
  bool quiet = false;
};

// A wrong command line; what(): one line. Exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

void need(const std::string& error) {
  if (!error.empty()) throw UsageError(error);
}

double number_of(const app::Arguments& arguments, std::string_view name, double low, double high,
                 double otherwise) {
  const auto text = arguments.value(name);
  if (!text) return otherwise;
  double value = 0;
  need(app::parse_number(*text, "--" + std::string(name), low, high, value));
  return value;
}

int integer_of(const app::Arguments& arguments, std::string_view name, int low, int high, int otherwise) {
  const auto text = arguments.value(name);
  if (!text) return otherwise;
  std::int64_t value = 0;
  need(app::parse_integer(*text, "--" + std::string(name), low, high, value));
  return static_cast<int>(value);
}

void parse_nodata(std::string_view list, Bake& job) {
  bool fill = false;
  while (true) {
    const std::size_t comma = list.find(',');
    const std::string_view word = list.substr(0, comma);
    if (word == "fill" || word == "hole") {
      fill = fill || word == "fill";
      job.leave_holes = job.leave_holes || word == "hole";
    } else {
      double value = 0;
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
      if (word.empty() || error != std::errc() || end != word.data() + word.size()) {
        throw UsageError("--nodata: '" + std::string(word) + "' is not a number, fill or hole");
      }
      job.read.nodata.push_back(value);
    }
    if (comma == std::string_view::npos) break;
    list.remove_prefix(comma + 1);
  }
  if (fill && job.leave_holes) throw UsageError("--nodata: both fill and hole");
}

void parse_crop(std::string_view text, Bake& job) {
  double values[4];
  need(app::parse_numbers(text, "--crop", ',', values));
  for (int k = 0; k < 4; ++k) {
    const double v = values[k];
    if (!(v >= (k < 2 ? 0 : 2) && v <= kMaxElevationSide) || v != static_cast<int>(v)) {
      throw UsageError("--crop: not four whole numbers X,Z,W,H with W and H of 2 or more");
    }
    job.read.crop[k] = static_cast<int>(v);
  }
}

void parse_source(const app::Arguments& arguments, Bake& job) {
  const auto sample = arguments.value("sample");
  if (sample && !arguments.positional().empty()) throw UsageError("both a DEM and --sample are given");
  if (!sample) {
    if (arguments.positional().size() != 1)
      throw UsageError("one DEM or --sample NAME is needed; see --help");
    job.read.path = arguments.positional()[0];
    return;
  }
  const auto names = sample_names();
  if (std::none_of(names.begin(), names.end(), [&](const SampleName& n) { return n.name == *sample; })) {
    std::string known;
    for (const SampleName& n : names) known += (known.empty() ? "" : ", ") + std::string(n.name);
    throw UsageError("--sample: '" + std::string(*sample) + "' is not one of " + known);
  }
  for (const char* option : {"pixel-size", "z-scale", "nodata", "crop", "allow-8bit"}) {
    if (arguments.has(option))
      throw UsageError("--" + std::string(option) + ": only for a DEM, not for --sample");
  }
  job.sample = *sample;
}

void parse_materials(const app::Arguments& arguments, MaterialOptions& options) {
  options.path = arguments.value("materials").value_or("");
  options.none = options.path == "none";
  if (options.none) options.path.clear();
  if (arguments.has("material-side")) {
    const int side = integer_of(arguments, "material-side", kLeastTextureSide, kMostTextureSide, 0);
    if (!std::has_single_bit(static_cast<unsigned>(side)))
      throw UsageError("--material-side: not a power of two");
    options.side = side;
  }
  const auto format = arguments.value("material-format");
  if (!format) return;
  if (*format != "etc2" && *format != "rgba8") throw UsageError("--material-format: not one of etc2, rgba8");
  options.format = *format == "etc2" ? TextureFormat::etc2 : TextureFormat::rgba8;
}

CommandLine parse(const app::Arguments& arguments) {
  CommandLine line;
  Bake& job = line.job;
  parse_source(arguments, job);
  if (!arguments.has("output")) throw UsageError("-o WORLD.karst is needed; see --help");
  line.output = *arguments.value("output");
  line.stats = arguments.value("stats").value_or("");
  line.json = arguments.has("json");
  line.quiet = arguments.has("quiet");
  job.voxel_m = number_of(arguments, "voxel", 1e-6, 1e9, 0);
  job.level = integer_of(arguments, "levels", 1, kMaxLevel, 0);
  const int all = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
  job.threads = integer_of(arguments, "threads", 1, kMaxThreads, all);
  parse_materials(arguments, job.materials);
  job.carve_path = arguments.value("carve").value_or("");
  job.read.pixel_size_m = number_of(arguments, "pixel-size", kMinSpacingM, kMaxSpacingM, 0);
  job.read.z_scale = number_of(arguments, "z-scale", -1e9, 1e9, 1);
  if (job.read.z_scale == 0) throw UsageError("--z-scale: 0 leaves no heights");
  job.read.allow_8bit = arguments.has("allow-8bit");
  if (const auto list = arguments.value("nodata")) parse_nodata(*list, job);
  if (const auto text = arguments.value("crop")) parse_crop(*text, job);
  return line;
}

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  const std::string error = app::write_file_atomic(path, bytes);
  if (!error.empty()) throw BakeError(error);
}

void check_output(const std::string& path) {
  const std::string error = app::check_writable(path);
  if (!error.empty()) throw BakeError(error);
}

void run(const CommandLine& line) {
  // Before any work: a bake that cannot be written is a minute lost.
  check_output(line.output);
  if (!line.stats.empty()) check_output(line.stats);

  const auto start = std::chrono::steady_clock::now();
  std::unique_ptr<app::Progress> bar;
  ReportProgress progress;
  if (!line.quiet) {
    progress = [&bar](const char* stage, std::uint64_t done, std::uint64_t total) {
      if (bar == nullptr) bar = std::make_unique<app::Progress>(stage, total);
      bar->update(done);
    };
  }
  Bake::Report report;
  const std::vector<std::byte> world = line.job.run(report, progress);
  if (bar != nullptr) bar->finish();
  write_file(line.output, world);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  const std::string json = report_json(line.job, report, world.size(), seconds);
  if (!line.stats.empty()) write_file(line.stats, std::as_bytes(std::span(json)));
  if (line.json) {
    std::fputs(json.c_str(), stdout);
  } else if (!line.quiet) {
    std::fputs(report_text(line.job, report, world.size(), seconds).c_str(), stdout);
  }
  if (std::fflush(stdout) != 0) throw BakeError("standard output: cannot be written");
}

void print_help() {
  std::fputs(kHelp, stdout);
  for (const SampleName& name : sample_names()) {
    std::printf("                         %-8s %s\n", std::string(name.name).c_str(),
                std::string(name.what).c_str());
  }
  std::fputs(kHelpOptions + 1, stdout);
}

int run_main(int count, char** words) {
  static constexpr app::Option kOptions[] = {
      {"output", 'o'},
      {"sample"},
      {"voxel"},
      {"levels"},
      {"pixel-size"},
      {"z-scale"},
      {"nodata"},
      {"crop"},
      {"carve"},
      {"materials"},
      {"material-side"},
      {"material-format"},
      {"threads"},
      {"stats"},
      {"allow-8bit", 0, false},
      {"json", 0, false},
      {"quiet", 0, false},
      {"help", 'h', false},
  };
  try {
    app::Arguments arguments;
    const auto given = static_cast<std::size_t>(std::max(count - 1, 0));
    need(arguments.parse(std::span<const char* const>(words + 1, given), kOptions));
    if (arguments.has("help")) {
      print_help();
      return app::kExitOk;
    }
    run(parse(arguments));
    return app::kExitOk;
  } catch (const UsageError& e) {
    app::print_error("karst-bake", e.what());
    return app::kExitUsage;
  } catch (const std::bad_alloc&) {
    app::print_error("karst-bake", "out of memory; use a lower --levels or a larger --voxel");
    return app::kExitFailure;
  } catch (const std::exception& e) {
    app::print_error("karst-bake", e.what());
    return app::kExitFailure;
  }
}

}  // namespace
}  // namespace karst::bake

int main(int count, char** words) {
  return karst::bake::run_main(count, words);
}
