// SPDX-License-Identifier: MIT
#include "app/view/view_options.h"

#include "app/motion/pose_stream.h"

namespace karst::app {
namespace {

using Kind = ValueKind;

constexpr double kLongest_s = 1e9;  // more than a machine's life

Error store_mode(void* options, const OptionValue& value) {
  return parse_mode(value.text, value.what, static_cast<ViewOptions*>(options)->kms.mode);
}

Error store_kms(void* options, const OptionValue& value) {
  KmsOptions& kms = static_cast<ViewOptions*>(options)->kms;
  kms.atomic = value.text != "legacy";
  kms.legacy = value.text != "atomic";
  return {};
}

Error store_window(void* options, const OptionValue&) {
  static_cast<ViewOptions*>(options)->output = ViewOptions::Output::window;
  return {};
}

Error store_headless(void* options, const OptionValue&) {
  auto& view = *static_cast<ViewOptions*>(options);
  if (view.output == ViewOptions::Output::window) return "--window and --headless exclude each other";
  view.output = ViewOptions::Output::headless;
  return {};
}

Error store_poses(void* options, const OptionValue& value) {
  static_cast<ViewOptions*>(options)->poses = value.text;
  return check_pose_source(value.text);
}

constexpr OptionRow kDisplayRows[] = {
    {.name = "card",
     .kind = Kind::file,
     .value = "PATH",
     .initial = "the first card with a monitor",
     .help = "/dev/dri/card1 or /dev/dri/by-path/...",
     .store = put<&ViewOptions::kms, &KmsOptions::card>},
    {.name = "connector",
     .kind = Kind::text,
     .value = "NAME",
     .initial = "the first with a monitor",
     .help = "HDMI-A-1, ...",
     .store = put<&ViewOptions::kms, &KmsOptions::connector>},
    {.name = "mode",
     .kind = Kind::other,
     .value = "MODE",
     .initial = "preferred",
     .help = "preferred, highest or WxH[@HZ]",
     .store = store_mode},
    {.name = "mode-fallback",
     .help = "takes another connector or mode where the wanted one is not there",
     .store = put<&ViewOptions::kms, &KmsOptions::mode_fallback>},
    {.name = "rotate",
     .kind = Kind::word,
     .value = "DEG",
     .initial = "0",
     .words = "0 90 180 270",
     .help = "turns the picture counter-clockwise by 0, 90, 180 or 270 degrees",
     .store = put<&ViewOptions::kms, &KmsOptions::quarter_turns>},
    {.name = "format",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "the board's, or xrgb8888",
     .words = "xrgb8888 rgb565",
     .help = "xrgb8888, or rgb565: 16 bits a pixel",
     .store = put<&ViewOptions::kms, &KmsOptions::format>},
    {.name = "buffers",
     .kind = Kind::integer,
     .value = "N",
     .initial = "the board's, or 2",
     .min = 2,
     .max = 3,
     .help = "3 is smoother where frames are now and then late",
     .store = put<&ViewOptions::kms, &KmsOptions::buffers>},
    {.name = "kms",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto atomic legacy",
     .help = "auto, atomic, or legacy calls only",
     .store = store_kms},
    {.name = "no-modifiers",
     .help = "plain buffer layouts only",
     .store = put_false<&ViewOptions::kms, &KmsOptions::modifiers>},
    {.name = "seat",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto libseat direct",
     .help = "auto, libseat (seatd or logind), direct",
     .store = put<&ViewOptions::seat>},
    {.name = "no-supervisor",
     .help = "nobody gives the console back when this program is killed",
     .store = put_false<&ViewOptions::supervise>},
    {.name = "wait",
     .kind = Kind::number,
     .value = "SECONDS",
     .initial = "for ever",
     .unit = "s",
     .max = kLongest_s,
     .help = "gives up when no display comes in this time",
     .store = put<&ViewOptions::wait_s>},
    {.name = "window",
     .help = "in a window of the desktop, where the program was built with it",
     .store = store_window},
    {.name = "headless", .help = "without any display", .store = store_headless},
    {.name = "list-outputs", .help = "prints connectors and modes", .store = put<&ViewOptions::list_outputs>},
    {.name = "json", .help = "prints them for programs", .store = put<&ViewOptions::json>},
};

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

constexpr OptionGroup kDisplayGroups[] = {{"display", kDisplayRows}};
constexpr OptionGroup kRunGroups[] = {{"motion", kMotionRows}, {"editing", kEditRows}, {"run", kRunRows}};
constexpr OptionPart kParts[] = {kDisplayGroups, kCameraGroups, kRunGroups, kSceneGroups};

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
  void* const targets[] = {&options, &options.camera, &options, &options.scene};
  if (Error error = line.store(targets); !error.ok()) return error;
  if (!line.has("format") && options.scene.rgb565) options.kms.format = ColourFormat::rgb565;
  if (!line.has("buffers")) options.kms.buffers = options.scene.buffers;
  options.scene.rgb565 = options.kms.format == ColourFormat::rgb565;
  return check_scene(options.scene, line.has("drape-repeat"));
}

}  // namespace karst::app
