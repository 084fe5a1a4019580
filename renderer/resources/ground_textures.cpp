// SPDX-License-Identifier: MIT
#include "renderer/resources/ground_textures.h"

#include <algorithm>
#include <iterator>

#include "renderer/gl/gl_state.h"
#include "renderer/resources/object_table.h"
#include "terrain/field/sky_line.h"

namespace karst::core {

Status fill_sky_line(const Gl& gl, const RendererSettings& settings, const GlObjects& /*objects*/) {
  float row[1 << kMaxDepth];
  std::fill(std::begin(row), std::end(row), -1e4f);  // below everything
  for (int z = 0; z < settings.extent.z; ++z) {
    gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, z, settings.extent.x, 1, GL_RED, GL_FLOAT, row);
  }
  return {};
}

void upload_sky_line(const GlDevice& device, const RendererSettings& settings, const Octree& octree) {
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::sky_line));
  SkyLine rows(octree, settings.extent);
  float row[1 << kMaxDepth];
  for (int z = 0; z < settings.extent.z; ++z) {
    rows.next(row);
    device.gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, z, settings.extent.x, 1, GL_RED, GL_FLOAT, row);
  }
  device.gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
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
