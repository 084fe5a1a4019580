// SPDX-License-Identifier: MIT
#include "renderer/resources/ground_textures.h"

#include <algorithm>
#include <iterator>

#include "renderer/gl/gl_state.h"
#include "renderer/resources/object_table.h"

namespace karst::core {

Status fill_sky(const Gl& gl, const RendererSettings& settings, const GlObjects& /*objects*/) {
  constexpr int kRows = 16;
  std::uint8_t open[kRows * SkyVisibility::kMostSide];
  std::fill(std::begin(open), std::end(open), std::uint8_t{255});
  const glm::ivec3 cells = settings.sky.cells;
  for (int y = 0; y < cells.y; ++y) {
    for (int z = 0; z < cells.z; z += kRows) {
      gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, z, y, cells.x, std::min(kRows, cells.z - z), 1, GL_RED,
                       GL_UNSIGNED_BYTE, open);
    }
  }
  return {};
}

Status upload_sky(const GlDevice& device, const RendererSettings& settings, const SkyVisibility& sky) {
  if (sky.grid() != settings.sky) {
    return {StatusCode::invalid_argument, "of another grid than the settings'", "sky"};
  }
  const glm::ivec3 cells = settings.sky.cells;
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_3D, name_of(device, Object::sky_visibility));
  device.gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, cells.x, cells.z, cells.y, GL_RED, GL_UNSIGNED_BYTE,
                          sky.cells().data());
  device.gl.BindTexture(GL_TEXTURE_3D, 0);
  leave_upload(device);
  return {};
}

Status upload_drape(const GlDevice& device, const RendererSettings& settings,
                    std::span<const std::uint8_t> rgba) {
  const std::size_t bytes =
      static_cast<std::size_t>(settings.drape_width) * static_cast<std::size_t>(settings.drape_height) * 4;
  if (bytes == 0) return {StatusCode::invalid_argument, "the settings have no image", "drape_width"};
  if (rgba.size() < bytes) return {StatusCode::invalid_argument, "too short", "rgba", bytes};
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::drape));
  device.gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, settings.drape_width, settings.drape_height, GL_RGBA,
                          GL_UNSIGNED_BYTE, rgba.data());
  device.gl.GenerateMipmap(GL_TEXTURE_2D);
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
  return {};
}

}  // namespace karst::core
