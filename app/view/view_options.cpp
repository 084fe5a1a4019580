// SPDX-License-Identifier: MIT
#include "app/view/view_options.h"

#include "app/motion/pose_stream.h"

namespace karst::app {
namespace {

using Kind = ValueKind;

constexpr double kLongest_s = 1e9;  // more than a machine's life

Error store_poses(void* options, const OptionValue& value) {
  static_cast<ViewOptions*>(options)->poses = value.text;
  return check_pose_source(value.text);
}

constexpr OptionRow kMotionRows[] = {
    {.name = "path-hz",
     .kind = Kind::number,
     .value = "HZ",
     .initial = "60",
     .unit = "lines a second",
     .min = 1e-3,
     .max = 1e3,
     .help = "how fast --path is flown",
     .store = put<&ViewOptions::path_hz>},
    {.name = "loop", .help = "begins the path again at its end", .store = put<&ViewOptions::loop>},
    {.name = "poses",
     .kind = Kind::other,
     .value = "WHERE",
     .help = "takes lines as --path has them from - (standard input), udp:PORT (of this machine only), or "
             "udp:ADDRESS:PORT; the newest is shown",
     .store = store_poses},
    {.name = "navigate",
     .kind = Kind::word,
     .value = "MODE",
     .initial = "fly",
     .words = "fly orbit walk none",
     .help = "fly, orbit, walk or none: keys w a s d, q e, arrows, mouse, wheel, touch",
     .store = put<&ViewOptions::navigate>},
    {.name = "clock",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "real",
     .words = "real fixed",
     .help = "real, or fixed: each frame is 1/60 s of the world's time",
     .store = put<&ViewOptions::fixed_clock>},
};

Error store_edit_memory(void* options, const OptionValue& value) {
  static_cast<ViewOptions*>(options)->edit_bytes = static_cast<std::uint64_t>(value.integer) << 20;
  return {};
}

constexpr OptionRow kEditRows[] = {
    {.name = "edit",
     .help =
         "digs, fills and shapes the world by hand: h shows the keys, F5 saves; what is not saved is kept "
         "beside the world, in WORLD.journal",
     .store = put<&ViewOptions::edit>},
    {.name = "edit-out",
     .kind = Kind::file,
     .value = "FILE",
     .initial = "WORLD",
     .help = "where it is saved",
     .store = put<&ViewOptions::edit_files, &EditSession::Files::output>},
    {.name = "discard-edits",
     .help = "forgets what an earlier run did and did not save, which is done again otherwise",
     .store = put<&ViewOptions::edit_files, &EditSession::Files::discard>},
    {.name = "edit-memory",
     .kind = Kind::integer,
     .value = "MIB",
     .initial = "128",
     .unit = "MiB",
     .min = 4,
     .max = 4096,
     .help = "for edits; a quarter of it holds what can be taken back",
     .store = store_edit_memory},
};

constexpr OptionRow kRunRows[] = {
    {.name = "frames",
     .kind = Kind::integer,
     .value = "N",
     .min = 1,
     .max = 1e12,
     .help = "draws N frames, changed or not, and ends",
     .store = put<&ViewOptions::frames>},
    {.name = "seconds",
     .kind = Kind::number,
     .value = "S",
     .unit = "s",
     .min = 1e-3,
     .max = kLongest_s,
     .help = "ends after this time",
     .store = put<&ViewOptions::seconds>},
    {.name = "stats",
     .kind = Kind::file,
     .value = "FILE.json",
     .help = "what the frames cost; - prints it; at the end and at SIGHUP",
     .store = put<&ViewOptions::stats>},
};

constexpr OptionGroup kRunGroups[] = {{"motion", kMotionRows}, {"editing", kEditRows}, {"run", kRunRows}};
constexpr OptionPart kParts[] = {kScreenGroups, kCameraGroups, kRunGroups, kSceneGroups};

}  // namespace

constinit const CommandSpec kViewSpec = {
    .name = "karst view",
    .brief = "shows a world on a display or in a window",
    .usage = "WORLD [options]\n--list-outputs [--card PATH] [--json]",
    .about =
        "Shows a world on a bare display (DRM/KMS), in a window, or nowhere. Draws when something changes "
        "and sleeps otherwise; SIGTERM and Ctrl-C end it and give the console back, SIGHUP writes the "
        "statistics. With --edit the world is dug, filled and shaped.",
    .parts = kParts,
    .examples =
        "karst view canyon.karst\n"
        "karst view hills.karst --edit\n"
        "karst view hills.karst --window --edit --edit-out dug.karst\n"
        "karst view canyon.karst --connector HDMI-A-1 --mode 1920x1080@60 --rotate 90\n"
        "simulator | karst view canyon.karst --poses - --navigate none\n"};

Error parse_view_options(std::span<const char* const> words, CommandLine& line, ViewOptions& options) {
  if (Error error = line.parse(words, kViewSpec); !error.ok()) return error;
  if (line.wants_help()) return {};
  const bool lists = line.has("list-outputs");
  const std::size_t worlds = line.positional().size();
  if (worlds > 1) return "more than one WORLD";
  if (worlds == 0 && !lists) return "which WORLD?";
  if (worlds == 1 && lists) return "--list-outputs takes no WORLD";
  if (line.has("json") && !lists) return "--json goes with --list-outputs";
  if (line.has("path") && line.has("poses")) return "--path and --poses exclude each other";
  if (worlds == 1) options.world = options.edit_files.world = line.positional()[0];
  for (const char* name : {"edit-out", "discard-edits", "edit-memory"}) {
    if (line.has(name) && !line.has("edit")) return std::string("--") + name + " goes with --edit";
  }
  void* const targets[] = {static_cast<ScreenArguments*>(&options), &options.camera, &options,
                           &options.scene};
  if (Error error = line.store(targets); !error.ok()) return error;
  if (!line.has("format") && options.scene.rgb565) options.kms.format = ColourFormat::rgb565;
  if (!line.has("buffers")) options.kms.buffers = options.scene.buffers;
  options.scene.rgb565 = options.kms.format == ColourFormat::rgb565;
  return check_scene(options.scene, line.has("drape-repeat"));
}

}  // namespace karst::app
