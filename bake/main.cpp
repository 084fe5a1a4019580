// SPDX-License-Identifier: MIT
// karst-bake: elevation images, samples and fields to world files.
#include "app/command_line/help.h"
#include "app/command_line/manual.h"
#include "app/common/arguments.h"
#include "app/common/progress.h"
#include "app/files/atomic_file.h"
#include "app/files/output_place.h"
#include "bake/bake_options.h"
#include "bake/base/child.h"
#include "bake/child_tasks.h"
#include "bake/fields/field_materials_file.h"
#include "bake/ground/bake_ground.h"
#include "bake/pipeline/report.h"

#include <chrono>
#include <cstdio>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace karst::bake {
using namespace core;
namespace {

// The files that a bake reads.
std::vector<app::NamedFile> files_read(const BakeOptions& options) {
  const Bake& job = options.job;
  std::vector<app::NamedFile> files{
      {"--carve", job.carve_path}, {"--materials", job.materials.path}, {"--features", job.features_path}};
  for (std::string& file : job.read.files()) {
    const bool named = file == job.read.path;
    files.push_back({named ? "DEM" : "a file of the DEM", std::move(file)});
  }
  for (std::string& image : material_images(job.materials)) {
    files.push_back({"an image of --materials", std::move(image)});
  }
  files.push_back({"--field", options.field.path});
  const std::string& codes = options.field.materials_path;
  files.push_back({"--field-materials", codes == kLayers ? std::string() : codes});
  for (const std::string& image : options.imagery.files) files.push_back({"--imagery", image});
  return files;
}

Error tell(const BakeOptions& options, const std::string& json, const std::string& text) {
  if (!options.stats.empty()) {
    Error error = app::write_file_atomic(options.stats, std::as_bytes(std::span(json)));
    if (!error.ok()) return error;
  }
  if (options.json) {
    std::fputs(json.c_str(), stdout);
  } else if (!options.quiet) {
    std::fputs(text.c_str(), stdout);
  }
  return {};
}

Error run(const BakeOptions& options) {
  const app::NamedFile outputs[] = {{"--output", options.output}, {"--stats", options.stats}};
  if (Error error = app::check_outputs_apart(outputs, files_read(options)); !error.ok()) return error;
  // Before any work: a bake that cannot be written is a minute lost.
  if (Error error = app::check_writable(options.output); !error.ok()) return error;
  if (!options.stats.empty()) {
    if (Error error = app::check_writable(options.stats); !error.ok()) return error;
  }

  const auto start = std::chrono::steady_clock::now();
  std::unique_ptr<app::Progress> bar;
  std::string_view shown;  // the bar's stage
  ReportProgress progress;
  if (!options.quiet) {
    progress = [&bar, &shown](const char* stage, std::uint64_t done, std::uint64_t total) {
      if (shown != stage) {
        if (bar != nullptr) bar->finish();
        bar = std::make_unique<app::Progress>(stage, total);
        shown = stage;
      }
      bar->update(done);
    };
  }
  const auto ended = [&](const Error& failed, const std::vector<std::string>& warnings) {
    if (bar != nullptr && failed.ok()) bar->finish();
    for (const std::string& warning : warnings) app::print_error("karst-bake", "warning: " + warning);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };
  if (options.is_field()) {
    BakeField::Report report;
    std::vector<std::byte> world;
    Error failed = options.field.run(report, world);
    if (failed.ok()) failed = app::write_file_atomic(options.output, world);
    const double seconds = ended(failed, report.warnings);
    if (!failed.ok()) return failed;
    return tell(options, field_report_json(options.field, report, world.size(), seconds),
                field_report_text(options.field, report, world.size(), seconds));
  }
  if (options.ground) {
    const BakeGround ground{options.job, options.output, options.imagery};
    BakeGround::Report report;
    const Error failed = ground.run(report, progress);
    const double seconds = ended(failed, report.warnings);
    if (!failed.ok()) return failed;
    return tell(options, ground_report_json(ground, report, seconds),
                ground_report_text(options.job, report, seconds));
  }
  Bake::Report report;
  std::vector<std::byte> world;
  Error failed = options.job.run(report, progress, world);
  if (failed.ok()) failed = app::write_file_atomic(options.output, world);
  const double seconds = ended(failed, report.warnings);
  if (!failed.ok()) return failed;
  return tell(options, report_json(options.job, report, world.size(), seconds),
              report_text(options.job, report, world.size(), seconds));
}

int run_main(std::span<const char* const> words) {
  if (!words.empty() && std::string_view(words[0]) == "--print-manual") {
    static constexpr const app::CommandSpec* kCommands[] = {&kBakeSpec};
    return app::print_manual({"karst-bake", kBakeSpec.brief, "", kCommands}, words.subspan(1));
  }
  try {
    app::CommandLine line;
    BakeOptions options;
    if (const Error usage = parse_bake_options(words, line, options); !usage.ok()) {
      app::print_error("karst-bake", usage.text());
      return app::kExitUsage;
    }
    if (line.wants_help()) {
      std::fputs(app::help_text(kBakeSpec).c_str(), stdout);
    } else if (line.has("version")) {
      std::puts("karst-bake " KARST_VERSION);
    } else if (const Error error = run(options); !error.ok()) {
      app::print_error("karst-bake", error.text());
      return app::kExitFailure;
    }
    return app::kExitOk;
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
  karst::app::keep_standard_files();
  const std::span<char* const> all(words, static_cast<std::size_t>(count));
  if (const std::optional<int> code = karst::bake::serve_as_child(all, karst::bake::child_tasks()))
    return *code;
  const int code = karst::bake::run_main({all.data() + 1, all.empty() ? 0 : all.size() - 1});
  if (code != karst::app::kExitOk) return code;
  const karst::Error error = karst::app::flush_output();
  if (error.ok()) return code;
  karst::app::print_error("karst-bake", error.text());
  return karst::app::kExitFailure;
}
