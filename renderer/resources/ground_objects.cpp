// SPDX-License-Identifier: MIT
#include "renderer/resources/ground_objects.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "renderer/gl/gl_state.h"
#include "renderer/resources/object_table.h"
#include "terrain/shading/surroundings.h"

namespace karst::core {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

// Clockwise seen from above, x to the east and z to the south: out is to the left.
std::int32_t yaw_between(glm::ivec3 before, glm::ivec3 after) {
  const double x = static_cast<double>(after.z - before.z);
  const double z = static_cast<double>(before.x - after.x);
  return static_cast<std::int32_t>(std::lround(std::atan2(z, x) / kTurn * 65536.0));
}

}  // namespace

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

Status upload_sky(const GlDevice& device, const RendererSettings& settings, const SkyVisibility& sky,
                  std::size_t place) {
  if (place >= settings.sky.count || sky.grid() != settings.sky.places[place].grid) {
    return {StatusCode::invalid_argument, "of another grid than the settings'", "sky"};
  }
  const glm::ivec3 cells = sky.grid().cells;
  enter_upload(device);
  device.gl.BindTexture(GL_TEXTURE_3D, name_of(device, Object::sky_visibility));
  device.gl.TexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, settings.sky.places[place].first, cells.x, cells.z, cells.y,
                          GL_RED, GL_UNSIGNED_BYTE, sky.cells().data());
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

GLenum gl_format(ImageFormat format) {
  switch (format) {
    case ImageFormat::etc2_rgb:
      return GL_COMPRESSED_SRGB8_ETC2;
    case ImageFormat::etc2_rgba:
      return GL_COMPRESSED_SRGB8_ALPHA8_ETC2_EAC;
    case ImageFormat::none:
    case ImageFormat::rgba8:
      break;
  }
  return GL_SRGB8_ALPHA8;
}

Status upload_image(const GlDevice& device, const RendererSettings& settings, std::uint32_t layer,
                    std::span<const std::byte> texels) {
  const ImageFormat format = settings.image_format;
  if (layer >= settings.image_layers) return {StatusCode::invalid_argument, "not a layer", "layer", layer};
  if (texels.size() != image_texel_bytes(format))
    return {StatusCode::invalid_argument, "of another size than a tile's", "texels", texels.size()};
  const Gl& gl = device.gl;
  enter_upload(device);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, name_of(device, Object::image_tiles));
  for (int level = 0; level < kImageLevels; ++level) {
    const GLsizei side = kImageSide >> level;
    const std::size_t bytes = image_level_bytes(format, level);
    const auto at = static_cast<GLint>(layer);
    if (format == ImageFormat::rgba8) {
      gl.TexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, at, side, side, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                       texels.data());
    } else {
      gl.CompressedTexSubImage3D(GL_TEXTURE_2D_ARRAY, level, 0, 0, at, side, side, 1, gl_format(format),
                                 static_cast<GLsizei>(bytes), texels.data());
    }
    texels = texels.subspan(bytes);
  }
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  leave_upload(device);
  return {};
}

Status upload_image_table(const GlDevice& device, const RendererSettings& settings, std::uint32_t view,
                          int size, std::span<const std::uint16_t> part) {
  if (view >= settings.image_views) return {StatusCode::invalid_argument, "not a view", "view", view};
  if (size < 0 || size >= kImageSizes || part.size() != kImageWindowTiles)
    return {StatusCode::invalid_argument, "not a size's window", "part", part.size()};
  const Gl& gl = device.gl;
  enter_upload(device);
  gl.BindTexture(GL_TEXTURE_2D, name_of(device, Object::image_table));
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, kImageWindow * static_cast<GLint>(view), kImageWindow * size,
                   kImageWindow, kImageWindow, GL_RED_INTEGER, GL_UNSIGNED_SHORT, part.data());
  gl.BindTexture(GL_TEXTURE_2D, 0);
  leave_upload(device);
  return {};
}

std::size_t rim_bytes(const RendererSettings& settings) {
  return settings.has_rim() ? 2 * (most_rim_points(settings.extent) + 1) * sizeof(RimVertex) : 0;
}

Status upload_rim(const GlDevice& device, const RendererSettings& settings, std::span<const glm::ivec3> rim,
                  std::int32_t plain_steps, std::uint32_t& vertices) {
  vertices = 0;
  if (rim.empty()) return {};
  if (2 * (rim.size() + 1) * sizeof(RimVertex) > rim_bytes(settings))
    return {StatusCode::invalid_argument, "more points than there is room for", "rim", rim.size()};
  constexpr std::size_t kPiece = 64;  // points
  RimVertex piece[2 * kPiece];
  device.gl.BindBuffer(GL_ARRAY_BUFFER, name_of(device, Object::rim));
  for (std::size_t first = 0; first <= rim.size(); first += kPiece) {
    const std::size_t count = std::min(kPiece, rim.size() + 1 - first);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t n = (first + k) % rim.size();
      RimVertex& top = piece[2 * k + 1];
      top.position = rim[n];
      top.normal_yaw = yaw_between(rim[(n + rim.size() - 1) % rim.size()], rim[(n + 1) % rim.size()]);
      piece[2 * k] = top;
      piece[2 * k].position.y = plain_steps;
    }
    device.gl.BufferSubData(GL_ARRAY_BUFFER, static_cast<GLintptr>(2 * first * sizeof(RimVertex)),
                            static_cast<GLsizeiptr>(2 * count * sizeof(RimVertex)), piece);
  }
  device.gl.BindBuffer(GL_ARRAY_BUFFER, 0);
  vertices = static_cast<std::uint32_t>(2 * (rim.size() + 1));
  return {};
}

}  // namespace karst::core
