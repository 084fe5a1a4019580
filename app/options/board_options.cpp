// SPDX-License-Identifier: MIT
#include "app/options/board_options.h"

#include "app/files/whole_file.h"

namespace karst::app {

Error read_board(std::string_view text, BoardProfile& profile) {
  if (!text.ends_with(".board")) {
    const Error error = find_board(text, profile);
    return error.ok() ? error : Error("--board: " + error.text());
  }
  const std::string path(text);
  WholeFile file;
  if (Error error = file.open(path, WholeFile::kMostText); !error.ok()) return error;
  const std::string_view content = file.text();
  Error error = parse_board(content, path, profile);
  profile.name = path;
  return error;
}

void set_board(const BoardProfile& profile, SceneArguments& scene) {
  scene.width = profile.width;
  scene.height = profile.height;
  scene.level = profile.level;
  scene.error_px = profile.error_px;
  scene.vertex_bytes = profile.vertex_bytes;
  scene.rgb565 = profile.rgb565;
  scene.buffers = profile.buffers;
  scene.shading = profile.deferred ? ShadingChoice::deferred : ShadingChoice::forward;
  scene.detail = static_cast<DetailChoice>(profile.detail);
  scene.antialias = profile.antialias;
  scene.shadows = profile.cascades;
  if (profile.cascades > 0) scene.shadow_size = profile.cascade_side;
  scene.max_cpu = profile.cpu_bytes;
  scene.max_memory = profile.cpu_bytes + profile.gpu_bytes;
}

}  // namespace karst::app
