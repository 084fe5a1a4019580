// SPDX-License-Identifier: MIT
// karst edit: does to a world what a script says, and saves it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/command_line/command_line.h"
#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/progress.h"
#include "app/edit/edit_script.h"
#include "app/edit/journal_file.h"
#include "app/edit/save_file.h"
#include "app/files/atomic_file.h"
#include "app/files/file_source.h"
#include "app/files/output_place.h"
#include "app/files/whole_file.h"
#include "karst/karst.h"
#include "platform/base/error.h"

namespace karst::app {
namespace {

struct EditOptions {
  std::string script;
  std::string output;
};

constexpr OptionRow kRows[] = {
    {.name = "script",
     .kind = ValueKind::file,
     .value = "FILE",
     .help = "the edits, JSON: one object a line, or a list",
     .store = put<&EditOptions::script>},
    {.name = "output",
     .letter = 'o',
     .kind = ValueKind::file,
     .value = "FILE",
     .help = "the world as it is then; may be WORLD itself",
     .store = put<&EditOptions::output>},
};
constexpr OptionGroup kGroups[] = {{"options", kRows}};
constexpr OptionPart kParts[] = {kGroups};

struct Free {
  void operator()(std::byte* p) const { std::free(p); }
};

// A world that can be edited, with memory of its own.
class EditedWorld {
 public:
  EditedWorld() = default;
  EditedWorld(const EditedWorld&) = delete;
  EditedWorld& operator=(const EditedWorld&) = delete;
  ~EditedWorld() {
    if (editor != nullptr) world->release(editor);
    if (world != nullptr) world->destroy();
  }

  // needs: of edits; the rest is as little as there can be.
  Error open(const std::string& path, const Needs& needs) {
    if (Error error = file.open(path); !error.ok()) return error;
    source = file.source();
    Plan plan;
    plan.needs = needs;
    plan.placement.axes = Axes::east_up_south;
    WorldInfo info;
    if (const Status status = read_world_info(source, info); !status.ok()) return {path, status};
    if (info.ground_samples[0] == 0) plan.needs.edit_tiles = 0;
    if (info.patches == 0 && !info.can_be_dug) plan.needs.edit_patches = 0;
    if (!info.can_be_dug) plan.needs.dig_regions = 0;
    if (info.field_samples[0] == 0) plan.needs.field_sample_blocks = 0;
    if (info.field_samples[0] == 0 || info.materials == 0) plan.needs.field_material_blocks = 0;
    if (info.materials == 0) plan.needs.paint_width = plan.needs.paint_depth = 0;
    if (const Status status = make_plan(source, plan); !status.ok()) return {path, status};
    memory.reset(static_cast<std::byte*>(std::aligned_alloc(
        kMemoryAlignment, (plan.cpu_bytes + kMemoryAlignment - 1) / kMemoryAlignment * kMemoryAlignment)));
    if (memory == nullptr) return path + ": no memory for " + std::to_string(plan.cpu_bytes) + " bytes";
    const std::span<std::byte> room(memory.get(), static_cast<std::size_t>(plan.cpu_bytes));
    Status status = World::create(plan, source, room, world);
    if (status.ok()) status = world->take_editor(editor);
    return status.ok() ? Error() : Error(path, status);
  }

  FileSource file;
  Source source;
  std::unique_ptr<std::byte, Free> memory;
  World* world = nullptr;
  Editor* editor = nullptr;
};

// An edit of a script, in the stroke of the one before it or in a new one.
Status apply_edit(Editor& editor, const ScriptStep& step, bool& in_stroke, ScriptCounts& counts) {
  if (!step.joined || !in_stroke) editor.begin_stroke();
  in_stroke = true;
  EditResult result;
  const Status status = editor.apply(step.what, result);
  if (!status.ok()) return status;
  ++counts.edits;
  counts.unchanged += !result.changed;
  return {};
}

// limit_reached ("undo_bytes") where there is a step that is not kept any more.
Status take_step(Editor& editor, bool back, ScriptCounts& counts) {
  editor.end_stroke();
  const UndoState state = editor.undo_state();
  EditResult result;
  if (back && state.undo_steps == 0 && state.lost_steps > 0)
    return {StatusCode::limit_reached, "more is taken back than there is memory for", "undo_bytes"};
  if ((back ? state.undo_steps : state.redo_steps) == 0) return {};
  ++(back ? counts.undone : counts.redone);
  return back ? editor.undo(result) : editor.redo(result);
}

// Does all of it. full: a limit that the plan was too small for.
Error apply_all(Editor& editor, const std::vector<ScriptStep>& steps, const std::string& script,
                ScriptCounts& counts, Status& full) {
  Progress progress("edit", steps.size());
  counts = {};
  bool in_stroke = false;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const bool is_edit = steps[n].kind == ScriptStep::edit;
    const Status status = is_edit ? apply_edit(editor, steps[n], in_stroke, counts)
                                  : take_step(editor, steps[n].kind == ScriptStep::undo, counts);
    if (!is_edit) in_stroke = false;
    if (!status.ok()) {
      full = status;
      return Error(script + ": edit " + std::to_string(n), status);
    }
    progress.update(n + 1);
  }
  editor.end_stroke();
  return {};
}

constexpr std::uint32_t kFirstEditPatches = 65'536;
constexpr std::uint32_t kMostEditPatches = 1u << 20;
// Where a script takes something back.
constexpr std::uint64_t kFirstUndoBytes = 1u << 20;
constexpr std::uint64_t kMostUndoBytes = 1u << 30;
constexpr std::uint32_t kFirstEditTiles = 256;
constexpr std::uint32_t kFirstFieldBlocks = 512;
constexpr std::uint64_t kMostFieldBlocks = 1u << 20;
// Texels of the painted map of a world that has none.
constexpr std::uint32_t kPaintSide = 1'024;
bool paints(const ScriptStep& step) {
  return step.kind == ScriptStep::edit && step.what.tool == EditTool::paint;
}
constexpr std::uint32_t kMostEditTiles = 65'536;

// What a limit that was reached has to be; false: it cannot be more.
bool raise(const Status& full, Needs& needs) {
  if (full.code() != StatusCode::limit_reached || full.field() == nullptr) return false;
  const std::string_view field = full.field();
  if (field == "edit_patches" && needs.edit_patches < kMostEditPatches) {
    needs.edit_patches *= 4;
    return true;
  }
  if (field == "undo_bytes" && needs.undo_bytes < kMostUndoBytes) {
    needs.undo_bytes = std::min(16 * needs.undo_bytes, kMostUndoBytes);
    return true;
  }
  if (field == "dig_regions" && full.value() <= kMostRegions) {
    needs.dig_regions = std::min(2 * needs.dig_regions, kMostRegions);
    return true;
  }
  if (field == "region_patches" && needs.region_patches < kMostEditPatches) {
    needs.region_patches = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        2 * full.value(), 2 * std::uint64_t{needs.region_patches}, kMostEditPatches));
    return true;
  }
  if (field == "field_sample_blocks" && needs.field_sample_blocks + full.value() <= kMostFieldBlocks) {
    needs.field_sample_blocks = static_cast<std::uint32_t>(
        std::min<std::uint64_t>(2 * (needs.field_sample_blocks + full.value()), kMostFieldBlocks));
    return true;
  }
  if (field == "field_material_blocks" && needs.field_material_blocks + full.value() <= kMostFieldBlocks) {
    needs.field_material_blocks = static_cast<std::uint32_t>(
        std::min<std::uint64_t>(2 * (needs.field_material_blocks + full.value()), kMostFieldBlocks));
    return true;
  }
  if (field == "edit_tiles" && full.value() <= kMostEditTiles) {
    // Later edits take more.
    needs.edit_tiles = static_cast<std::uint32_t>(std::min<std::uint64_t>(2 * full.value(), kMostEditTiles));
    return true;
  }
  return false;
}

Error run_script(const EditOptions& options, const std::string& path) {
  const NamedFile output{"--output", options.output};
  const NamedFile script{"--script", options.script};
  if (Error error = check_outputs_apart(std::span(&output, 1), std::span(&script, 1)); !error.ok())
    return error;
  WholeFile text;
  if (Error error = text.open(options.script, WholeFile::kMostText); !error.ok()) return error;
  std::vector<ScriptStep> steps;
  if (Error error = parse_script(text.text(), options.script, steps); !error.ok()) return error;
  ScriptCounts counts;
  if (Error error = check_writable(options.output); !error.ok()) return error;
  if (Error error = check_not_edited(options.output); !error.ok()) return error;
  Needs needs;
  needs.shadow_maps = 0;
  needs.max_cpu_bytes = needs.max_gpu_bytes = UINT64_MAX;
  needs.edit_patches = kFirstEditPatches;
  needs.dig_regions = 2;
  if (std::ranges::any_of(steps, [](const ScriptStep& one) { return one.kind == ScriptStep::undo; }))
    needs.undo_bytes = kFirstUndoBytes;
  needs.edit_tiles = kFirstEditTiles;
  needs.field_sample_blocks = kFirstFieldBlocks;
  if (std::ranges::any_of(steps, paints)) {
    needs.paint_width = needs.paint_depth = kPaintSide;
    needs.field_material_blocks = kFirstFieldBlocks;
  }
  for (;;) {
    EditedWorld edited;
    if (Error error = edited.open(path, needs); !error.ok()) return error;
    if (Error error = find_materials(edited.world->info(), options.script, steps); !error.ok()) return error;
    Status full;
    if (Error error = apply_all(*edited.editor, steps, options.script, counts, full); !error.ok()) {
      if (raise(full, needs)) continue;
      return error;
    }
    std::uint64_t bytes = 0;
    if (Error error = save_file(*edited.editor, options.output, {}, bytes, edited.source.bytes); !error.ok())
      return error;
    std::printf("%s: %zu edits (%zu changed nothing), %zu taken back, %zu done again; %llu bytes\n",
                options.output.c_str(), counts.edits, counts.unchanged, counts.undone, counts.redone,
                static_cast<unsigned long long>(bytes));
    return {};
  }
}

}  // namespace

constinit const CommandSpec kEditSpec = {
    .name = "karst edit",
    .brief = "digs, raises and smooths a world by a script",
    .usage = "WORLD --script FILE -o FILE",
    .about =
        "Does to a world what a script says, one edit after the other, and writes the world as it is then. "
        "The same script makes the same bytes. Where an edit cannot be done, nothing is written.\n\n"
        "A script is JSON, one object a line or a list of them. Places are metres in the world's own axes, "
        "to the east, up and to the south, as cameras have them; docs/editing.md has the fields. clear and "
        "fill are of voxels, in worlds without a ground (karst-bake --no-ground) and where a ground has a "
        "region (--carve) or can be dug (--dig); extrude, smooth, noise, flatten and level are of heights, "
        "of such voxels' surface "
        "where there is no ground or of a ground on a plane with its regions; paint is of materials. A field "
        "(karst-bake --field) is cut with clear, fill, smooth, flatten and level.",
    .parts = kParts,
    .examples =
        "karst-bake --sample hills --no-ground -o hills.karst\n"
        "echo '{\"tool\": \"clear\", \"place_m\": [0, 20, 0], \"radius_m\": 20}' > hole.json\n"
        "karst edit hills.karst --script hole.json -o hole.karst\n"
        "karst-bake dem.tif --dig --voxel 4 -o dem.karst\n"
        "karst edit dem.karst --script tunnel.json -o dug.karst\n"
        "echo '{\"tool\": \"extrude\", \"shape\": \"cylinder\", \"place_m\": [0, 0, 0], \"radius_m\": 300, "
        "\"strength_m\": 80}' > hill.json\n"
        "karst edit dem.karst --script hill.json -o dem.karst\n"
        "karst-bake --field-shape gyroid --field-size 128,128,128 -o cave.karst\n"
        "karst edit cave.karst --script hole.json -o dug.karst\n"};

int run_edit(std::span<const char* const> words) {
  CommandLine line;
  EditOptions options;
  Error usage = line.parse(words, kEditSpec);
  if (usage.ok() && line.wants_help()) {
    std::fputs(help_text(kEditSpec).c_str(), stdout);
    return kExitOk;
  }
  void* const targets[] = {&options};
  if (usage.ok()) usage = line.store(targets);
  if (usage.ok() && line.positional().size() != 1) usage = "takes one WORLD";
  if (usage.ok() && options.script.empty()) usage = "--script FILE is missing: the edits";
  if (usage.ok() && options.output.empty()) usage = "-o FILE is missing: where the world goes";
  if (!usage.ok()) {
    print_error("karst edit", usage.text());
    return kExitUsage;
  }
  const Error error = run_script(options, std::string(line.positional()[0]));
  if (!error.ok()) print_error("karst edit", error.text());
  return error.ok() ? kExitOk : kExitFailure;
}

}  // namespace karst::app
