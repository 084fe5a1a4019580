// SPDX-License-Identifier: MIT
#include "app/options/scene_options.h"

#include <cmath>

#include "app/common/arguments.h"
#include "app/options/board_options.h"
#include "app/options/scene_ranges.h"

namespace karst::app {
namespace {

Error store_board(void* options, const OptionValue& value) {
  auto& scene = *static_cast<SceneArguments*>(options);
  BoardProfile board;
  Error error = read_board(value.text, board);
  if (!error.ok()) return error;
  scene.board = value.text;
  set_board(board, scene);
  return {};
}

Error store_size(void* options, const OptionValue& value) {
  auto& scene = *static_cast<SceneArguments*>(options);
  scene.width = value.width;
  scene.height = value.height;
  return {};
}

Error store_sun(void* options, const OptionValue& value) {
  auto& scene = *static_cast<SceneArguments*>(options);
  double sun[2] = {0, 0};
  if (Error error = parse_numbers(value.text, value.what, ',', sun); !error.ok()) return error;
  const auto wrong = [&](const char* text) { return std::string(value.what) + text; };
  if (std::fabs(sun[0]) > 360) return wrong(": not within -360..360 degrees (sun_azimuth_deg)");
  if (std::fabs(sun[1]) > 90) return wrong(": not within -90..90 degrees (sun_elevation_deg)");
  scene.sun_azimuth_deg = sun[0];
  scene.sun_elevation_deg = sun[1];
  return {};
}

Error store_no_skip(void* options, const OptionValue& value) {
  std::uint32_t& drawn = static_cast<SceneArguments*>(options)->drawn_anyway;
  for (std::string_view list = value.text;;) {
    const std::size_t comma = list.find(',');
    const std::string_view name = list.substr(0, comma);
    bool known = false;
    for (int n = 0; n < kSkipCount; ++n) {
      if (name != kSkipNames[n] && name != "all") continue;
      drawn |= 1u << n;
      known = true;
    }
    if (!known) {
      std::string error = std::string(value.what) + ": '";
      error.append(name).append("' is none of");
      for (const char* skip : kSkipNames) error.append(" ").append(skip);
      return error.append(" all");
    }
    if (comma == std::string_view::npos) return {};
    list.remove_prefix(comma + 1);
  }
}

Error store_vertex_memory(void* options, const OptionValue& value) {
  static_cast<SceneArguments*>(options)->vertex_bytes = static_cast<std::uint64_t>(value.number * (1 << 20));
  return {};
}

Error store_max_memory(void* options, const OptionValue& value) {
  static_cast<SceneArguments*>(options)->max_memory = static_cast<std::uint64_t>(value.integer) << 20;
  return {};
}

Error store_shadow_size(void* options, const OptionValue& value) {
  if (value.integer % kShadowSizeStep != 0) {
    return std::string(value.what) + ": not a multiple of " + std::to_string(kShadowSizeStep);
  }
  return put<&SceneArguments::shadow_size>(options, value);
}

Error store_camera(void* options, const OptionValue& value) {
  auto& camera = *static_cast<CameraArguments*>(options);
  camera.has_camera = true;
  return parse_camera(value.text, value.what, camera.camera);
}

Error store_anisotropy(void* options, const OptionValue& value) {
  // Words are auto, 1, 2, 4, 8 and 16.
  static_cast<SceneArguments*>(options)->anisotropy = value.integer == 0 ? 0 : 1 << (value.integer - 1);
  return {};
}

using Kind = ValueKind;

constexpr OptionRow kPictureRows[] = {
    {.name = "board",
     .kind = Kind::other,
     .value = "BOARD",
     .help =
         "size, level, colours, shadows and memory of a board, by name (karst budget --list-boards) or by "
         "FILE.board; other options come on top",
     .store = store_board},
    {.name = "size",
     .kind = Kind::size,
     .value = "WxH",
     .initial = "1280x720",
     .max = kMostPicture,
     .help = "of the picture in pixels; of karst view: of the window, or of the picture without a display",
     .store = store_size},
    {.name = "sun",
     .kind = Kind::other,
     .value = "AZ,EL",
     .initial = "230,35",
     .help = "azimuth clockwise from north and elevation above the horizon in degrees",
     .store = store_sun},
    {.name = "fov",
     .kind = Kind::number,
     .value = "DEG",
     .initial = "60",
     .unit = "degrees",
     .min = 1,
     .max = 170,
     .help = "of the picture's height",
     .store = put<&SceneArguments::fov_y_deg>},
    {.name = "haze",
     .kind = Kind::number,
     .value = "VOXELS",
     .initial = "six times the world's size",
     .min = 1e-3,
     .max = 1e7,
     .help = "distance at which 63 % of the light is haze",
     .store = put<&SceneArguments::haze_voxels>},
    {.name = "show",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "materials",
     .words = "materials cascades levels lookups",
     .help =
         "materials; cascades: the shadow map of each pixel; levels: triangles, by their level of detail; "
         "lookups: the redder, the more texture lookups a pixel takes",
     .store = put<&SceneArguments::show>},
    {.name = "precision",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto medium high",
     .help = "high: all of a pixel in 32 bits; medium: 16 where that is enough; auto: high where a processor "
             "renders",
     .store = put<&SceneArguments::precision>},
    {.name = "detail",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "medium",
     .words = "low medium high",
     .help = "of textures: low, far scale alone; medium, the near one's nearest mip; high, mips are mixed",
     .store = put<&SceneArguments::detail>},
    {.name = "anisotropy",
     .kind = Kind::word,
     .value = "N",
     .initial = "auto",
     .words = "auto 1 2 4 8 16",
     .help = "lookups in the ground's textures mix 1, 2, 4, 8 or 16 places at most along a pixel's longer "
             "side, so that ground at a grazing angle is sharp; auto: 4, or 1 where a processor renders",
     .store = store_anisotropy},
    {.name = "shading",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "auto",
     .words = "auto forward deferred",
     .help = "of pixels: forward, while they are drawn; deferred, once, from a G-buffer of 12 bytes a pixel; "
             "auto: deferred where a processor renders",
     .store = put<&SceneArguments::shading>},
    {.name = "antialias",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "the board's, or none",
     .words = "none edges msaa2 msaa4",
     .help = "none; edges: silhouettes, where shading is deferred; msaa2, msaa4: 2 or 4 samples a pixel, "
             "shading forward; msaa4 takes 36 bytes of memory a pixel instead of 8",
     .store = put<&SceneArguments::antialias>},
    {.name = "no-skip",
     .kind = Kind::other,
     .value = "NAME,...",
     .help = "draws what could be skipped; NAME: frustum, backface, occlusion, cascades, triplanar, blend, "
             "detail, sun (of pixels), material, cave (of patches), all",
     .store = store_no_skip},
};

constexpr OptionRow kLevelRows[] = {
    {.name = "lod",
     .kind = Kind::word,
     .value = "NAME",
     .initial = "error",
     .words = "error distance full",
     .help = "error: the coarsest levels within --error-px; distance: by distance alone, and levels of "
             "voxels do not morph; full: the finest level everywhere",
     .store = put<&SceneArguments::lod>},
    {.name = "error-px",
     .kind = Kind::number,
     .value = "E",
     .initial = "4",
     .unit = "pixels",
     .min = kLeastErrorTarget,
     .max = kMostErrorTarget,
     .help = "no drawn point is further from the full surface",
     .store = put<&SceneArguments::error_px>},
    {.name = "lod-distance",
     .kind = Kind::number,
     .value = "V",
     .initial = "64",
     .unit = "voxels",
     .max = kMostReach,
     .help = "of --lod distance: from here on level 1 is drawn, a level finer for each halving",
     .store = put<&SceneArguments::lod_distance_voxels>},
    {.name = "level",
     .kind = Kind::integer,
     .value = "N",
     .initial = "the world's",
     .min = 1,
     .max = kMostLevel,
     .help = "draws no finer than level N; saves GPU memory",
     .store = put<&SceneArguments::level>},
    {.name = "generate-ms",
     .kind = Kind::number,
     .value = "MS",
     .initial = "karst view: 4; else as long as it takes",
     .max = 1e6,
     .help =
         "time a frame to make vertices; frames that would take longer are coarser than --error-px and say "
         "so",
     .store = put<&SceneArguments::generate_ms>},
    {.name = "vertex-memory",
     .kind = Kind::number,
     .value = "MIB",
     .initial = "what the whole world takes coarsely, and about as much again",
     .max = 1024,
     .help = "of the GPU; where it is too little, frames are coarser than --error-px and say so",
     .store = store_vertex_memory},
    {.name = "max-memory",
     .kind = Kind::integer,
     .value = "MIB",
     .initial = "512",
     .min = 1,
     .max = 1 << 20,
     .help = "CPU and GPU together; heights that find no room are read when needed",
     .store = store_max_memory},
};

constexpr OptionRow kShadowRows[] = {
    {.name = "shadows",
     .kind = Kind::integer,
     .value = "N",
     .initial = "2",
     .max = kMostShadows,
     .help = "shadow maps of the sun, each over a larger part of the world",
     .store = put<&SceneArguments::shadows>},
    {.name = "shadow-size",
     .kind = Kind::integer,
     .value = "N",
     .initial = "1024",
     .unit = "texels a side of each, a multiple of 16",
     .min = kLeastShadow,
     .max = kMostShadow,
     .store = store_shadow_size},
    {.name = "shadow-reach",
     .kind = Kind::number,
     .value = "V",
     .initial = "256",
     .unit = "voxels",
     .min = 4,
     .max = kMostReach,
     .help = "from the eye that they cover, where the world is larger",
     .store = put<&SceneArguments::shadow_reach_voxels>},
};

constexpr OptionRow kDrapeRows[] = {
    {.name = "drape",
     .kind = Kind::file,
     .value = "IMAGE.png",
     .help =
         "lays an image over the world from above, north up, in place of its materials; sky and light are "
         "plain, without shadow maps",
     .store = put<&SceneArguments::drape>},
    {.name = "drape-repeat",
     .kind = Kind::number,
     .value = "N",
     .initial = "1",
     .min = 0x1p-10,
     .max = 0x1p10,
     .help = "covers the world N times on each axis",
     .store = put<&SceneArguments::drape_repeat>},
};

constexpr OptionRow kCameraRows[] = {
    {.name = "camera",
     .kind = Kind::other,
     .value = "X,Y,Z,YAW,PITCH",
     .initial = "the whole world is shown; karst view, where keys fly or walk: 1.7 m above the ground in its "
                "middle, key 0 shows the whole",
     .help = "place in metres, angles in degrees: yaw 0 looks north (-z) and grows to the left, pitch grows "
             "upwards; ~H for Y stands H metres above the highest ground at X,Z; "
             "@LON,LAT,H,YAW,PITCH is by longitude and latitude, ~H above the ground there",
     .store = store_camera},
    {.name = "path",
     .kind = Kind::file,
     .value = "FILE",
     .help = "a frame for each line \"X Y Z YAW PITCH\", as above; # starts a comment",
     .store = put<&CameraArguments::path_file>},
};

}  // namespace

const OptionGroup kSceneGroups[4] = {{"picture", kPictureRows},
                                     {"levels and memory", kLevelRows},
                                     {"shadows", kShadowRows},
                                     {"drape", kDrapeRows}};
const OptionGroup kCameraGroups[1] = {{"camera", kCameraRows}};

std::vector<NamedFile> files_read(const std::string& world, const SceneArguments& scene,
                                  const CameraArguments& camera) {
  std::vector<NamedFile> files{{"WORLD", world}, {"--drape", scene.drape}, {"--path", camera.path_file}};
  if (scene.board.ends_with(".board")) files.push_back({"--board", scene.board});
  return files;
}

Error check_scene(const SceneArguments& scene, bool has_drape_repeat) {
  // A camera's aspect, CameraSettings.
  constexpr int kMostAspect = 64;
  if (scene.width > kMostAspect * scene.height || scene.height > kMostAspect * scene.width) {
    return "--size: " + std::to_string(scene.width) + "x" + std::to_string(scene.height) +
           ": one side is more than 64 times the other";
  }
  if (has_drape_repeat && scene.drape.empty()) return "--drape-repeat needs a --drape";
  return {};
}

}  // namespace karst::app
