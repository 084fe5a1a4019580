// SPDX-License-Identifier: MIT
// karst render: pictures and statistics of a world.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/atomic_file.h"
#include "app/common/camera_path.h"
#include "app/common/mapped_file.h"
#include "app/common/png_file.h"
#include "app/common/progress.h"
#include "app/common/status_text.h"
#include "app/options/board_options.h"
#include "app/options/skips.h"
#include "app/render/output_name.h"
#include "platform/base/clock.h"
#include "scene/frame_statistics.h"
#include "scene/scene.h"

namespace karst::app {
using namespace core;
namespace {

constexpr const char* kHelp =
    R"(usage: karst render WORLD [-o OUT.png] [options]

Draws a world that karst-bake made, without a screen.

  -o, --output FILE         the picture; for several frames OUT_0000.png, OUT_0001.png, ..., or frame%04d.png
                            says where the number goes
      --size WxH            of the picture in pixels (1280x720)
      --camera X,Y,Z,YAW,PITCH
                            place in metres, angles in degrees: yaw 0 looks north (-z) and grows to the left,
                            pitch grows upwards; without it the whole world is shown
      --path FILE           a frame for each line "X Y Z YAW PITCH"; # starts a comment
      --sun AZ,EL           azimuth clockwise from north and elevation above the horizon in degrees (230,35)
      --fov DEG             of the picture's height, 1 to 170 (60)
      --haze VOXELS         distance at which 63 % of the light is haze (six times the world's size)
      --level N             draws no finer than level N, 1 to 6; saves GPU memory
      --lod NAME            error: the coarsest levels within --error-px; distance: by distance alone,
                            nothing morphs; full: the finest level everywhere (error)
      --error-px E          no drawn point is further than E pixels from the full surface: 0.01 to 1000 (4)
      --lod-distance V      of --lod distance, in voxels: from here on level 1 is drawn, a level finer for
                            each halving (64)
      --drape IMAGE.png     lays an image over the world from above, north up, in place of its materials;
                            sky and light are plain
      --drape-repeat N      covers the world N times on each axis (1)
      --generate-ms MS      time a frame to make vertices; frames that would take longer are coarser than
                            --error-px and say so (all frames are complete)
      --no-skip NAME,...    draws what could be skipped; NAME: frustum, backface, occlusion, cascades,
                            triplanar, blend, detail, sun (of pixels), material, cave (of patches), all
      --show NAME           materials; cascades: the shadow map of each pixel; levels: triangles, by their
                            level of detail (materials)
      --precision NAME      high: all of a pixel in 32 bits; medium: 16 where that is enough (medium)
      --shadows N           shadow maps of the sun, 0 to 3, each over a larger part of the world (2)
      --shadow-size N       texels a side of each, 512 to 2048, a multiple of 16 (1024)
      --shadow-reach V      voxels from the eye that they cover, where the world is larger (256)
      --vertex-memory MIB   of the GPU (what the whole world takes coarsely, and about as much again); where
                            it is too little, frames are coarser than --error-px and say so
      --board NAME          size, level, colours and memory of a board; other options come on top (karst
                            budget --list-boards)
      --max-memory MIB      CPU and GPU together (512); heights that find no room are read when needed
      --stats FILE.json     what the frames cost and drew; - prints it
      --help                this text

  karst render canyon.karst -o canyon.png
  karst render canyon.karst -o near.png --camera 20,14,60,35,-5 --sun 120,20 --size 1920x1080
  karst render canyon.karst --path flight.txt --stats flight.json
)";

constexpr Option kOptions[] = {
    {"output", 'o'},   {"board"},        {"size"},        {"camera"},       {"path"},
    {"sun"},           {"fov"},          {"haze"},        {"level"},        {"lod"},
    {"error-px"},      {"lod-distance"}, {"drape"},       {"drape-repeat"}, {"no-skip"},
    {"precision"},     {"show"},         {"max-memory"},  {"stats"},        {"generate-ms"},
    {"vertex-memory"}, {"shadows"},      {"shadow-size"}, {"shadow-reach"}, {"help", 'h', false}};

struct RenderOptions {
  SceneOptions scene;
  std::string output;  // empty: no pictures
  std::string stats;   // empty: none
  std::string path_file;
  std::vector<CameraPlace> cameras;  // empty: overview
  FrameLight light;
  bool default_haze = true;
  double fov_y_deg = 60.0;
  LodSettings lod;
  SceneView skips;  // its switches alone
  double generate_ms = SceneView::kComplete;
};

// The options whose text alone decides whether they are right.
std::string read_options(const Arguments& arguments, RenderOptions& options) {
  std::string error;
  const auto number = [&](const char* name, double min, double max, double& out) {
    if (const auto text = arguments.value(name); text && error.empty()) {
      error = parse_number(*text, std::string("--") + name, min, max, out);
    }
  };
  const auto integer = [&](const char* name, std::int64_t min, std::int64_t max, std::int64_t& out) {
    if (const auto text = arguments.value(name); text && error.empty()) {
      error = parse_integer(*text, std::string("--") + name, min, max, out);
    }
  };
  if (const auto text = arguments.value("board")) {
    BoardProfile board;
    error = read_board(*text, board);
    set_board(board, options.scene);
    options.lod.error_px = board.error_px;
  }
  number("fov", 1, 170, options.fov_y_deg);
  number("haze", 1e-3, 1e7, options.light.haze_voxels);
  options.default_haze = !arguments.has("haze");
  number("error-px", kLeastErrorPx, kMostErrorPx, options.lod.error_px);
  number("shadow-reach", 4, kCameraReach, options.scene.shadows.reach_voxels);
  std::int64_t shadows = options.scene.shadows.count;
  integer("shadows", 0, kMostCascades, shadows);
  options.scene.shadows.count = static_cast<int>(shadows);
  std::int64_t shadow_size = options.scene.shadows.size;
  integer("shadow-size", 512, 2048, shadow_size);
  options.scene.shadows.size = static_cast<int>(shadow_size);
  if (shadow_size % 16 != 0 && error.empty()) error = "--shadow-size: not a multiple of 16";
  number("drape-repeat", 0x1p-10, 0x1p10, options.scene.drape_repeat);
  number("lod-distance", 0, kCameraReach, options.lod.distance_voxels);
  number("generate-ms", 0, 1e6, options.generate_ms);
  if (arguments.has("vertex-memory")) {
    double mib = 0;
    number("vertex-memory", 0, 1024, mib);
    options.scene.vertex_bytes = static_cast<std::uint64_t>(mib * (1 << 20));
  }
  std::int64_t level = options.scene.level;
  integer("level", 1, kMaxLevel, level);
  options.scene.level = static_cast<int>(level);
  auto mebibytes = static_cast<std::int64_t>(options.scene.max_memory >> 20);
  integer("max-memory", 1, 1 << 20, mebibytes);
  options.scene.max_memory = static_cast<std::uint64_t>(mebibytes) << 20;
  if (const auto text = arguments.value("size"); text && error.empty()) {
    error =
        parse_size(*text, "--size", RendererSettings::kMaxPicture, options.scene.width, options.scene.height);
  }
  if (const auto text = arguments.value("sun"); text && error.empty()) {
    double sun[2] = {0, 0};
    error = parse_numbers(*text, "--sun", ',', sun);
    options.light.sun_azimuth_deg = sun[0];
    options.light.sun_elevation_deg = sun[1];
    if (error.empty() && !options.light.validate().ok())
      error = status_text("--sun", options.light.validate());
  }
  if (const auto text = arguments.value("camera"); text && error.empty()) {
    error = parse_camera(*text, "--camera", options.cameras.emplace_back());
  }
  // One of the words; sets out to its place among them.
  const auto word = [&](const char* name, std::span<const char* const> words, auto& out) {
    const auto text = arguments.value(name);
    if (!text || !error.empty()) return;
    const auto found = std::find(words.begin(), words.end(), *text);
    if (found != words.end()) {
      out = static_cast<std::remove_reference_t<decltype(out)>>(found - words.begin());
      return;
    }
    error = std::string("--") + name + ": '" + std::string(*text) + "' is not one of";
    for (const char* w : words) error.append(" ").append(w);
  };
  constexpr const char* kModes[] = {"error", "distance", "full"};        // in the order of LodMode
  constexpr const char* kShown[] = {"materials", "cascades", "levels"};  // in the order of Show
  constexpr const char* kPrecisions[] = {"medium", "high"};
  word("lod", kModes, options.lod.mode);
  word("show", kShown, options.scene.show);
  word("precision", kPrecisions, options.scene.high_precision);
  if (const auto text = arguments.value("no-skip"); text && error.empty()) {
    error = switch_off_skips(*text, options.skips);
    if (!error.empty()) error = "--no-skip: " + error;
  }
  return error;
}

// What a wrong command line is told; empty where it is right.
std::string parse(std::span<const char* const> words, Arguments& arguments, RenderOptions& options) {
  if (std::string error = arguments.parse(words, kOptions); !error.empty()) return error;
  if (arguments.has("help")) return {};
  if (arguments.positional().size() != 1) {
    return arguments.positional().empty() ? "which WORLD?" : "more than one WORLD";
  }
  options.scene.world = arguments.positional()[0];
  options.output = arguments.value("output").value_or("");
  options.stats = arguments.value("stats").value_or("");
  options.path_file = arguments.value("path").value_or("");
  if (!arguments.has("output") && !arguments.has("stats"))
    return "nothing to do: give -o OUT.png or --stats FILE.json";
  if (arguments.has("camera") && arguments.has("path")) return "--camera and --path exclude each other";
  options.scene.drape = arguments.value("drape").value_or("");
  if (arguments.has("drape-repeat") && !arguments.has("drape")) return "--drape-repeat needs a --drape";
  for (const char* name : {"output", "stats", "path", "drape"}) {
    if (arguments.value(name) == "") return std::string("--") + name + ": the file name is empty";
  }
  if (std::string error = read_options(arguments, options); !error.empty()) return error;
  return options.output.empty() ? std::string() : OutputName().parse(options.output);
}

std::string read_path(RenderOptions& options) {
  if (options.path_file.empty()) return {};
  MappedFile file;
  if (std::string error = file.open(options.path_file); !error.empty()) return error;
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  return parse_camera_path(text, options.path_file, options.cameras);
}

class Render {
 public:
  explicit Render(RenderOptions options) : options_(std::move(options)) {}

  // Returns an empty string on success, else one line for the user.
  std::string run() {
    if (std::string error = read_path(options_); !error.empty()) return error;
    several_ = options_.cameras.size() > 1;
    if (std::string error = check_outputs(); !error.empty()) return error;
    if (std::string error = scene_.open(options_.scene); !error.empty()) return error;
    if (std::string error = place_cameras(); !error.empty()) return error;
    if (std::string error = draw_frames(); !error.empty()) return error;
    if (const GLenum code = scene_.renderer().take_error(); code != GL_NO_ERROR) {
      char text[64];
      std::snprintf(text, sizeof text, "OpenGL error 0x%04x; the pictures may be wrong",
                    static_cast<unsigned>(code));
      return text;
    }
    return write_statistics();
  }

 private:
  // Told before the work and not after it.
  std::string check_outputs() {
    if (!options_.output.empty()) {
      if (std::string error = output_.parse(options_.output); !error.empty()) return error;
      if (std::string error = check_writable(output_.frame(0, several_)); !error.empty()) return error;
    }
    return options_.stats.empty() || options_.stats == "-" ? std::string() : check_writable(options_.stats);
  }

  std::string place_cameras() {
    const WorldFrame frame = scene_.frame();
    const LatticeBox box = scene_.terrain().box();
    const double aspect = static_cast<double>(options_.scene.width) / options_.scene.height;
    if (options_.cameras.empty()) options_.cameras.push_back(overview(frame, box, options_.fov_y_deg));
    if (options_.default_haze) {
      const glm::dvec3 size = glm::dvec3(box.max - box.min) / static_cast<double>(kStepsPerVoxel);
      options_.light.haze_voxels = std::max(1.0, 6.0 * std::max(size.x, size.z));
    }
    for (std::size_t i = 0; i < options_.cameras.size(); ++i) {
      Camera& camera = cameras_.emplace_back();
      const Status status = place_camera(options_.cameras[i], frame, box, options_.fov_y_deg, aspect, camera);
      if (status.ok()) continue;
      const bool path = !options_.path_file.empty();
      return status_text(path ? options_.path_file + ": frame " + std::to_string(i) : "--camera", status);
    }
    return {};
  }

  std::string draw_frames() {
    Progress progress("drawing", cameras_.size());
    const auto pixels =
        static_cast<std::size_t>(options_.scene.width) * static_cast<std::size_t>(options_.scene.height);
    std::vector<std::uint8_t> rgba(options_.output.empty() ? 0 : pixels * 4);
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (std::string error = draw_frame(cameras_[i]); !error.empty()) return error;
      if (!options_.output.empty()) {
        if (std::string error = write_picture(i, rgba); !error.empty()) return error;
      }
      progress.update(i + 1);
    }
    return {};
  }

  std::string draw_frame(const Camera& camera) {
    SceneView view = options_.skips;
    view.camera = camera;
    view.light = options_.light;
    view.lod = options_.lod;
    view.lod.max_level = kMaxLevel;
    view.generate_ms = options_.generate_ms;
    return scene_.draw(view, records_.emplace_back());
  }

  std::string write_picture(std::size_t frame, std::vector<std::uint8_t>& rgba) {
    if (const Status status = scene_.renderer().read_colour(rgba); !status.ok())
      return status_text("picture", status);
    const std::string name = output_.frame(frame, several_);
    std::vector<std::byte> png;
    if (std::string error = encode_png(rgba, options_.scene.width, options_.scene.height, png);
        !error.empty()) {
      return name + ": " + error;
    }
    return write_file_atomic(name, png);
  }

  std::string write_statistics() {
    if (options_.stats.empty()) return {};
    const std::string text = statistics_json(scene_, records_);
    if (options_.stats == "-") {
      std::fputs(text.c_str(), stdout);
      return {};
    }
    return write_file_atomic(options_.stats, std::as_bytes(std::span(text)));
  }

  RenderOptions options_;
  OutputName output_;
  bool several_ = false;
  Scene scene_;
  std::vector<Camera> cameras_;
  std::vector<FrameRecord> records_;
};

}  // namespace

int run_render(std::span<const char* const> words) {
  Arguments arguments;
  RenderOptions options;
  const std::string usage = parse(words, arguments, options);
  if (!usage.empty()) {
    print_error("karst render", usage);
    return kExitUsage;
  }
  if (arguments.has("help")) {
    std::fputs(kHelp, stdout);
    return kExitOk;
  }
  if (const std::string error = Render(std::move(options)).run(); !error.empty()) {
    print_error("karst render", error);
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::app
