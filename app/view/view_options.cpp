// SPDX-License-Identifier: MIT
#include "app/view/view_options.h"

#include <algorithm>
#include <iterator>

#include "app/common/status_text.h"
#include "app/options/board_options.h"
#include "app/view/pose_stream.h"

namespace karst::app {

const char* const kViewHelp =
    R"(usage: karst view WORLD [options]
       karst view --list-outputs [--card PATH] [--json]

Shows a world on a bare display (DRM/KMS), in a window, or nowhere. Draws when something changes and sleeps
otherwise; SIGTERM and Ctrl-C end it and give the console back, SIGHUP writes the statistics.

display
      --card PATH           /dev/dri/card1 or /dev/dri/by-path/...; the first card with a monitor
      --board NAME          size, level, colours, buffers and memory of a board; other options come on top
      --connector NAME      HDMI-A-1, ...; the first with a monitor
      --mode MODE           preferred, highest or WxH[@HZ] (preferred)
      --mode-fallback       take another connector or mode where the wanted one is not there
      --rotate DEG          turns the picture counter-clockwise by 90, 180 or 270 degrees
      --format NAME         xrgb8888, or rgb565: 16 bits a pixel (xrgb8888)
      --buffers N           2, or 3: smoother where frames are now and then late (2)
      --kms NAME            auto, atomic, or legacy calls only (auto)
      --no-modifiers        plain buffer layouts only
      --seat NAME           auto, libseat (seatd or logind), direct (auto)
      --no-supervisor       nobody gives the console back when this program is killed
      --wait SECONDS        gives up when no display comes in this time; without it, it waits for ever
      --window              in a window of the desktop, where the program was built with it
      --headless            without any display
      --size WxH            of the window or the headless picture (1280x720)
      --list-outputs        prints connectors and modes; --json for programs

view
      --camera X,Y,Z,YAW,PITCH
                            as for karst render; without it the whole world is shown
      --path FILE           flies along a path, a line "X Y Z YAW PITCH" at --path-hz (60) a second; --loop
      --poses WHERE         takes lines "X Y Z YAW PITCH" from - (standard input), udp:PORT (of this machine
                            only), or udp:ADDRESS:PORT; the newest is shown
      --navigate MODE       fly, orbit, walk or none (fly): keys w a s d, q e, arrows, mouse, wheel, touch
      --clock NAME          real, or fixed: each frame is 1/60 s of the world's time (real)
      --frames N            draws N frames, changed or not, and ends
      --seconds S           ends after S seconds
      --stats FILE.json     what the frames cost; - prints it; at the end and at SIGHUP
      --sun AZ,EL  --fov DEG  --haze VOXELS  --level N  --lod NAME  --error-px E  --precision NAME
      --lod-distance V  --max-memory MIB  --vertex-memory MIB
      --generate-ms MS          time a frame to make vertices (4); until they are there frames are coarser
                            as for karst render
      --help                this text

  karst view canyon.karst
  karst view canyon.karst --connector HDMI-A-1 --mode 1920x1080@60 --rotate 90
  simulator | karst view canyon.karst --poses - --navigate none
)";

namespace {

constexpr Option kOptions[] = {{"card"},
                               {"board"},
                               {"connector"},
                               {"mode"},
                               {"mode-fallback", 0, false},
                               {"rotate"},
                               {"format"},
                               {"buffers"},
                               {"kms"},
                               {"no-modifiers", 0, false},
                               {"seat"},
                               {"no-supervisor", 0, false},
                               {"wait"},
                               {"window", 0, false},
                               {"headless", 0, false},
                               {"size"},
                               {"list-outputs", 0, false},
                               {"json", 0, false},
                               {"camera"},
                               {"path"},
                               {"path-hz"},
                               {"loop", 0, false},
                               {"poses"},
                               {"navigate"},
                               {"clock"},
                               {"frames"},
                               {"seconds"},
                               {"stats"},
                               {"sun"},
                               {"fov"},
                               {"haze"},
                               {"level"},
                               {"precision"},
                               {"lod"},
                               {"error-px"},
                               {"lod-distance"},
                               {"generate-ms"},
                               {"vertex-memory"},
                               {"max-memory"},
                               {"help", 'h', false}};

constexpr double kLongest_s = 1e9;  // more than a machine's life

// Reads options one after the other; after the first that is wrong it reads no more.
class Reader {
 public:
  explicit Reader(const Arguments& arguments) : arguments_(arguments) {}

  void number(const char* name, double min, double max, double& out) {
    const auto text = next(name);
    if (text) error_ = parse_number(*text, std::string("--") + name, min, max, out);
  }
  template <class T>
  void integer(const char* name, std::int64_t min, std::int64_t max, T& out) {
    const auto text = next(name);
    if (!text) return;
    std::int64_t value = 0;
    error_ = parse_integer(*text, std::string("--") + name, min, max, value);
    if (error_.empty()) out = static_cast<T>(value);
  }
  void text(const char* name, std::string& out) {
    const auto text = next(name);
    if (!text) return;
    out = *text;
    if (out.empty()) error_ = std::string("--") + name + ": it is empty";
  }
  // One of the words; sets out to its index.
  template <std::size_t n>
  std::size_t word(const char* name, const char* const (&words)[n], std::size_t otherwise) {
    const auto text = next(name);
    if (!text) return otherwise;
    const auto* found = std::find(std::begin(words), std::end(words), *text);
    if (found != std::end(words)) return static_cast<std::size_t>(found - words);
    error_ = std::string("--") + name + ": '" + std::string(*text) + "' is not one of";
    for (const char* w : words) error_.append(" ").append(w);
    return otherwise;
  }
  // The text where the option was given and all is well so far.
  std::optional<std::string_view> next(const char* name) {
    return error_.empty() ? arguments_.value(name) : std::nullopt;
  }
  void fail(std::string error) {
    if (error_.empty()) error_ = std::move(error);
  }
  const std::string& error() const { return error_; }

 private:
  const Arguments& arguments_;
  std::string error_;
};

void read_display(const Arguments& arguments, Reader& read, ViewOptions& options) {
  KmsOptions& kms = options.kms;
  if (const auto text = read.next("board")) {
    BoardProfile board;
    read.fail(read_board(*text, board));
    set_board(board, options.scene);
    options.lod.error_px = board.error_px;
    kms.format = board.rgb565 ? ColourFormat::rgb565 : ColourFormat::xrgb8888;
    kms.buffers = board.buffers;
  }
  read.text("card", kms.card);
  read.text("connector", kms.connector);
  if (const auto text = read.next("mode")) read.fail(parse_mode(*text, "--mode", kms.mode));
  kms.mode_fallback = arguments.has("mode-fallback");
  kms.quarter_turns = static_cast<int>(read.word("rotate", {"0", "90", "180", "270"}, 0));
  kms.format = static_cast<ColourFormat>(
      read.word("format", {"xrgb8888", "rgb565"}, static_cast<std::size_t>(kms.format)));
  read.integer("buffers", 2, 3, kms.buffers);
  const std::size_t calls = read.word("kms", {"auto", "atomic", "legacy"}, 0);
  kms.atomic = calls != 2;
  kms.legacy = calls != 1;
  kms.modifiers = !arguments.has("no-modifiers");
  options.seat = static_cast<SeatKind>(read.word("seat", {"auto", "libseat", "direct"}, 0));
  options.supervise = !arguments.has("no-supervisor");
  read.number("wait", 0, kLongest_s, options.wait_s);
  if (arguments.has("window") && arguments.has("headless"))
    read.fail("--window and --headless exclude each other");
  if (arguments.has("window")) options.output = ViewOptions::Output::window;
  if (arguments.has("headless")) options.output = ViewOptions::Output::headless;
  if (const auto text = read.next("size")) {
    read.fail(parse_size(*text, "--size", RendererSettings::kMaxPicture, options.scene.width,
                         options.scene.height));
  }
  options.scene.rgb565 = kms.format == ColourFormat::rgb565;
}

void read_view(const Arguments& arguments, Reader& read, ViewOptions& options) {
  if (const auto text = read.next("camera")) {
    options.has_camera = true;
    read.fail(parse_camera(*text, "--camera", options.camera));
  }
  read.text("path", options.path_file);
  read.number("path-hz", 1e-3, 1e3, options.path_hz);
  options.loop = arguments.has("loop");
  read.text("poses", options.poses);
  if (!options.poses.empty()) read.fail(check_pose_source(options.poses));
  options.navigate = static_cast<NavigatorMode>(
      read.word("navigate", {"fly", "orbit", "walk", "none"}, static_cast<std::size_t>(options.navigate)));
  options.clock.fixed = read.word("clock", {"real", "fixed"}, 0) == 1;
  read.integer("frames", 1, std::int64_t{1} << 40, options.frames);
  read.number("seconds", 1e-3, kLongest_s, options.seconds);
  read.text("stats", options.stats);
  if (arguments.has("path") && arguments.has("poses")) read.fail("--path and --poses exclude each other");
}

void read_picture(Reader& read, ViewOptions& options) {
  if (const auto text = read.next("sun")) {
    double sun[2] = {0, 0};
    read.fail(parse_numbers(*text, "--sun", ',', sun));
    options.light.sun_azimuth_deg = sun[0];
    options.light.sun_elevation_deg = sun[1];
    if (!options.light.validate().ok()) read.fail(status_text("--sun", options.light.validate()));
  }
  read.number("fov", 1, 170, options.fov_y_deg);
  options.default_haze = !read.next("haze").has_value();
  read.number("haze", 1e-3, 1e7, options.light.haze_voxels);
  read.integer("level", 1, kMaxLevel, options.scene.level);
  options.scene.high_precision = read.word("precision", {"medium", "high"}, 0) == 1;
  options.lod.mode = static_cast<LodMode>(
      read.word("lod", {"error", "distance", "full"}, static_cast<std::size_t>(options.lod.mode)));
  read.number("error-px", kLeastErrorPx, kMostErrorPx, options.lod.error_px);
  read.number("lod-distance", 0, kCameraReach, options.lod.distance_voxels);
  read.number("generate-ms", 0, 1e6, options.generate_ms);
  double vertex_mib = 0;
  read.number("vertex-memory", 0, 1024, vertex_mib);
  options.scene.vertex_bytes = static_cast<std::uint64_t>(vertex_mib * (1 << 20));
  std::uint64_t mebibytes = options.scene.max_memory >> 20;
  read.integer("max-memory", 1, 1 << 20, mebibytes);
  options.scene.max_memory = mebibytes << 20;
}

}  // namespace

std::string parse_view_options(std::span<const char* const> words, Arguments& arguments,
                               ViewOptions& options) {
  if (std::string error = arguments.parse(words, kOptions); !error.empty()) return error;
  if (arguments.has("help")) return {};
  options.list_outputs = arguments.has("list-outputs");
  options.json = arguments.has("json");
  const std::size_t worlds = arguments.positional().size();
  if (worlds > 1) return "more than one WORLD";
  if (worlds == 0 && !options.list_outputs) return "which WORLD?";
  if (worlds == 1 && options.list_outputs) return "--list-outputs takes no WORLD";
  if (options.json && !options.list_outputs) return "--json goes with --list-outputs";
  if (worlds == 1) options.scene.world = arguments.positional()[0];
  Reader read(arguments);
  read_display(arguments, read, options);
  read_view(arguments, read, options);
  read_picture(read, options);
  return read.error();
}

}  // namespace karst::app
