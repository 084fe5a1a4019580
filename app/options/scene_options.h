// SPDX-License-Identifier: MIT
// The options that say how a world is drawn: one table, which karst render, karst view and karst-bench share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app/command_line/option_table.h"
#include "app/common/camera_path.h"
#include "app/files/output_place.h"
#include "boards/board_profile.h"
#include "platform/base/error.h"

namespace karst::app {

// In the order of the options' words.
enum class ShadingChoice : std::uint8_t { automatic, forward, deferred };
enum class PrecisionChoice : std::uint8_t { automatic, medium, high };
enum class LodChoice : std::uint8_t { error, distance, full };
enum class ShowChoice : std::uint8_t { materials, cascades, levels, lookups };
enum class DetailChoice : std::uint8_t { low, medium, high };

// What a frame may skip, for --no-skip.
enum class SkipChoice : std::uint8_t {
  frustum,
  backface,
  occlusion,
  cascades,
  triplanar,
  blend,
  sun,
  material,
  detail,
  cave,
};
inline constexpr int kSkipCount = 10;
inline constexpr const char* kSkipNames[kSkipCount] = {"frustum",   "backface", "occlusion", "cascades",
                                                       "triplanar", "blend",    "sun",       "material",
                                                       "detail",    "cave"};

// What the command line says of a scene.
struct SceneArguments {
  static constexpr double kUnset = -1;

  std::string board;  // its name or file; empty: none

  int width = 1280;  // pixels
  int height = 720;
  double sun_azimuth_deg = 230;
  double sun_elevation_deg = 35;
  double haze_voxels = kUnset;  // unset: by the world's size
  double fov_y_deg = 60;
  ShowChoice show = ShowChoice::materials;
  ShadingChoice shading = ShadingChoice::automatic;
  DetailChoice detail = DetailChoice::medium;
  PrecisionChoice precision = PrecisionChoice::automatic;
  int anisotropy = 0;  // 0: as fits the device
  Antialias antialias = Antialias::none;
  std::uint32_t drawn_anyway = 0;  // bit n: SkipChoice n is switched off

  LodChoice lod = LodChoice::error;
  double error_px = 4;
  double lod_distance_voxels = 64;
  int level = 6;                            // finest that is drawn
  double generate_ms = kUnset;              // unset: the command's own
  std::uint64_t vertex_bytes = 0;           // 0: what the world takes coarsely, and about as much again
  std::uint64_t max_memory = 512ull << 20;  // bytes, CPU and GPU
  std::uint64_t max_cpu = 0;                // bytes of the CPU's alone; 0: no limit of its own

  int shadows = 2;  // maps
  int shadow_size = 1024;
  double shadow_reach_voxels = 256;

  std::string drape;  // PNG; empty: none
  double drape_repeat = 1;

  // Of a board alone.
  bool rgb565 = false;
  int buffers = 2;  // of scan-out
};

// Stored into SceneArguments. The board is the first option: the others come on top of what it sets.
extern const OptionGroup kSceneGroups[4];

// What the table cannot say of one option alone: --drape-repeat without --drape.
Error check_scene(const SceneArguments& scene, bool has_drape_repeat);

// Where pictures are taken from, of karst render and karst view.
struct CameraArguments {
  bool has_camera = false;
  CameraPlace camera;
  std::string path_file;  // empty: none
};
extern const OptionGroup kCameraGroups[1];

// The files that a command with these options reads, none of which may be an output of it.
std::vector<NamedFile> files_read(const std::string& world, const SceneArguments& scene,
                                  const CameraArguments& camera = {});

}  // namespace karst::app
