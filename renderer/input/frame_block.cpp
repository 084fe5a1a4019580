// SPDX-License-Identifier: MIT
#include "renderer/input/frame_block.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <glm/geometric.hpp>

#include "terrain/view/projection.h"

namespace karst::core {
namespace {

constexpr double kRadiansPerDegree = 3.14159265358979323846 / 180.0;
// Degrees that the sun is below the horizon: the light's direction becomes the moon's; night has come.
constexpr double kMoonTakesOverDeg = 5.0;
constexpr double kNightDeg = 13.0;

bool inside(double value, double least, double most) {
  return value >= least && value <= most;
}

float smooth_step(double low, double high, double value) {
  const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
  return static_cast<float>(t * t * (3.0 - 2.0 * t));
}

glm::vec3 mix(glm::vec3 a, glm::vec3 b, float t) {
  return a + (b - a) * t;
}

glm::vec4 xyz(glm::vec3 v) {
  return {v, 0.0f};
}

// Linear light, relative to a white surface in full sun being 3.5: the tone curve is made for that. The
// shares of sun and sky are those of a clear day: about 5 to 1 on level ground at noon.
//
// By night a full moon stands opposite to the sun. Moonlight is brighter here than it is, as much as an eye
// gets used to it, so that a display shows the ground. Nothing jumps at dusk: the sun is down before the
// light's direction becomes the moon's, and what is stronger on its side is so on no side then.
void set_light(const FrameLight& light, shader::FrameBlock& block) {
  const double elevation = light.sun_elevation_deg;
  const float height = smooth_step(0.0, 35.0, elevation);  // 0 at the horizon, 1 from mid-morning on
  const float day = smooth_step(-12.0, 8.0, elevation);    // fades to night below the horizon
  const float disc = smooth_step(-1.5, 1.5, elevation);    // the disc itself sets

  const float night = smooth_step(kMoonTakesOverDeg, kNightDeg, -elevation);
  const float dusk = smooth_step(-kMoonTakesOverDeg, 0.0, elevation);

  block.sun_direction = glm::vec4(glm::vec3(light_direction(light)), 0.4f * (dusk + night));
  block.sun_light = xyz(mix({3.1f, 1.65f, 0.85f}, {3.7f, 3.35f, 2.9f}, height) * disc +
                        glm::vec3(0.42f, 0.50f, 0.65f) * night);
  const glm::vec3 zenith = mix({0.10f, 0.16f, 0.34f}, {0.07f, 0.20f, 0.56f}, height);
  const glm::vec3 horizon = mix({0.72f, 0.54f, 0.44f}, {0.37f, 0.54f, 0.80f}, height);
  constexpr glm::vec3 kNightZenith{0.010f, 0.016f, 0.036f};
  constexpr glm::vec3 kNightHorizon{0.036f, 0.050f, 0.084f};
  block.sky_zenith = xyz(mix(kNightZenith, zenith, day));
  block.sky_horizon = xyz(mix(kNightHorizon, horizon, day));
  block.sky_zenith.w = night;
  block.sky_light = xyz((glm::vec3(block.sky_zenith) * 0.6f + glm::vec3(block.sky_horizon) * 0.4f) * 1.15f +
                        glm::vec3(0.06f, 0.08f, 0.12f) * (1.0f - day));
  // Light that the ground throws back: a brownish sixth of what falls on it.
  const float level = std::max(0.0f, block.sun_direction.y);
  block.ground_light = xyz((glm::vec3(block.sun_light) * level + glm::vec3(block.sky_light)) *
                           glm::vec3(0.19f, 0.16f, 0.125f));
}

}  // namespace

Status FrameLight::validate() const {
  if (!inside(sun_azimuth_deg, -360, 360)) {
    return {StatusCode::invalid_argument, "not within -360..360 degrees", "sun_azimuth_deg"};
  }
  if (!inside(sun_elevation_deg, -90, 90)) {
    return {StatusCode::invalid_argument, "not within -90..90 degrees", "sun_elevation_deg"};
  }
  if (!inside(haze_voxels, 1e-3, 1 << 24)) {
    return {StatusCode::invalid_argument, "not within 0.001..2^24 voxels", "haze_voxels"};
  }
  return {};
}

namespace {

void set_sky(const SkyAtlas& sky, shader::FrameBlock& block) {
  const SkyGrid& first = sky.places[0].grid;
  const float one = first.cell_voxels();
  block.sky_scale = glm::vec4(1.0f / (glm::vec3(sky.cells.x, sky.cells.z, sky.cells.y) * one), one);
  block.sky_octrees.x = static_cast<int>(sky.count);
  for (std::size_t n = 0; sky.count > 1 && n < sky.count; ++n) {
    const SkyAtlas::Place& place = sky.places[n];
    const float cell = place.grid.cell_voxels();
    block.sky_corner[n] = glm::vec4(glm::vec3(place.box.corner), cell);
    block.sky_box[n] = glm::vec4(place.box.extent.x, place.box.extent.z, place.first, place.grid.cells.y);
  }
}

}  // namespace

shader::FrameBlock make_frame_block(const Camera& camera, float least_cos2, const FrameLight& light,
                                    const SkyAtlas& sky, int height) {
  shader::FrameBlock block{};
  block.clip_from_lattice = clip_from_lattice(camera);
  block.camera_voxel = glm::ivec4(camera.voxel, 0);
  block.camera_fine = glm::vec4(camera.fine, 0.0f);
  block.morph_view = glm::vec4(make_lod_eye(camera, least_cos2).forward, least_cos2);
  const ViewRays rays = view_rays(camera);
  if (!camera.parallel) {
    block.ray_right = xyz(glm::vec3(rays.right));
    block.ray_up = xyz(glm::vec3(rays.up));
  }
  block.ray_forward = xyz(glm::vec3(rays.middle));

  set_light(light, block);
  block.view_scale.x = static_cast<float>(1.0 / light.haze_voxels);
  block.view_scale.y = static_cast<float>(2.0 * (1.0 / vertical_scale(camera)) / height);
  block.view_scale.z = camera.parallel ? 1.0f : 0.0f;
  set_sky(sky, block);
  return block;
}

void set_level(const FrameLevel& level, shader::FrameBlock& block) {
  block.level_x = level.view.x;
  block.level_y = level.view.y;
  block.level_z = level.view.z;
  block.level_eye = level.view.eye;
  block.level_top = glm::vec4(level.up, level.dip);
  block.level_air = {level.sky, level.thins, level.plain_over, level.has_plain ? 1.0f : 0.0f};
  if (!level.has_water) return;
  block.water.x = level.water_height - level.view.eye.w;
  block.water.z = level.water_height;
  block.water.w = level.water_over;
}

glm::dvec3 light_direction(const FrameLight& light) {
  const bool moon = light.sun_elevation_deg < -kMoonTakesOverDeg;
  if (light.towards != glm::dvec3(0.0)) return moon ? -light.towards : light.towards;
  const double azimuth = light.sun_azimuth_deg * kRadiansPerDegree;
  const double elevation = light.sun_elevation_deg * kRadiansPerDegree;
  const glm::dvec3 sun(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                       -std::cos(azimuth) * std::cos(elevation));
  return moon ? -sun : sun;
}

void set_cascades(const Camera& camera, const LightSpace& space, std::span<const Cascade> cascades, int size,
                  shader::FrameBlock& block) {
  const glm::dvec3 eye = eye_lattice(camera) / static_cast<double>(kStepsPerVoxel);
  const double depth = 1.0 / (space.near_z - space.far_z);  // a voxel
  block.shadow_x = xyz(glm::vec3(space.x));
  block.shadow_y = xyz(glm::vec3(space.y));
  block.shadow_z = glm::vec4(glm::vec3(space.z * -depth),
                             static_cast<float>((space.near_z - glm::dot(space.z, eye)) * depth));
  glm::vec4* const boxes[] = {&block.shadow_box_0, &block.shadow_box_1, &block.shadow_box_2};
  for (std::size_t n = 0; n < cascades.size(); ++n) {
    const Cascade& c = cascades[n];
    *boxes[n] = {static_cast<float>((glm::dot(space.x, eye) - c.low.x) / c.side),
                 static_cast<float>((glm::dot(space.y, eye) - c.low.y) / c.side),
                 static_cast<float>(1.0 / c.side), static_cast<float>(c.texel)};
  }
  block.shadow_scale = {static_cast<float>(cascades.size()), static_cast<float>(size),
                        1.0f / static_cast<float>(size), static_cast<float>(depth)};
}

shader::FrameBlock make_cascade_block(const Cascade& cascade) {
  shader::FrameBlock block{};
  block.clip_from_lattice = cascade.clip_from_lattice;
  block.camera_voxel = glm::ivec4(cascade.eye.voxel, 0);
  block.camera_fine = glm::vec4(cascade.eye.fine, 0.0f);
  block.morph_view = glm::vec4(glm::vec3(cascade.eye.forward), cascade.least_cos2);
  return block;
}

void set_lights(const Camera& camera, std::span<const PointLight> lights, bool guess_caves,
                shader::FrameBlock& block) {
  const glm::dvec3 eye = eye_lattice(camera) / static_cast<double>(kStepsPerVoxel);
  const std::size_t count = std::min<std::size_t>(lights.size(), kMostLights);
  for (std::size_t n = 0; n < count; ++n) {
    block.light_place[n] = glm::vec4(glm::vec3(glm::dvec3(lights[n].position) - eye), lights[n].radius);
    block.light_colour[n] = xyz(lights[n].colour);
  }
  block.light_scale = {static_cast<float>(count), guess_caves ? 1.0f : 0.0f, 0.0f, 0.0f};
}

float foot_from(const Camera& camera, std::int64_t height) {
  return static_cast<float>(height - std::int64_t{camera.voxel.y} * kStepsPerVoxel);
}

void set_drape(glm::ivec3 extent, double repeat, shader::FrameBlock& block) {
  const auto axis = [repeat](int voxels) {
    return static_cast<float>(repeat / std::max(1.0, static_cast<double>(voxels) - 1.0));
  };
  block.drape_place = {axis(extent.x), axis(extent.z), -0.5f * axis(extent.x), -0.5f * axis(extent.z)};
}

static_assert(KARST_IMAGE_WINDOW == kImageWindow && KARST_IMAGE_INSIDE == kImageInside &&
              KARST_IMAGE_BORDER == kImageBorder && KARST_MASK(KARST_IMAGE_LAYER_BITS) > kMostImageLayers);
void set_images(const ImagePlace& place, std::uint32_t view, int places_row, shader::FrameBlock& block) {
  block.image_centre = {place.centre[0], place.centre[1], 0, 0};
  block.image_sizes = {place.least_size, place.top_size, static_cast<int>(view), places_row};
  block.image_eye = {place.eye[0], place.eye[1], 0.0f, 0.0f};
  block.image_scale = {place.tiles_a_voxel[0], place.tiles_a_voxel[1], place.texels_a_voxel, 0.0f};
}

glm::vec3 encode_picture(glm::vec3 light) {
  for (int c = 0; c < 3; ++c) {
    const float s = std::min(std::sqrt(std::max(light[c], 0.0f)), 3.7f);
    const float shown = s * (-0.0893f + s * (3.9806f + s * -0.01675f)) / (1.0f + s * (-0.398f + s * 3.9345f));
    light[c] = std::max(shown, 0.0f);
  }
  return light;
}

glm::vec3 horizon_light(const FrameLight& light) {
  shader::FrameBlock block{};
  set_light(light, block);
  return block.sky_horizon;
}

shader::KarstAir make_air_block(const shader::FrameBlock& block, const glm::mat4& world) {
  shader::KarstAir air = {.karst_world = world,
                          .karst_sun_direction = block.sun_direction,
                          .karst_sun_light = block.sun_light,
                          .karst_sky_light = block.sky_light,
                          .karst_ground_light = block.ground_light,
                          .karst_sky_zenith = block.sky_zenith,
                          .karst_sky_horizon = block.sky_horizon,
                          .karst_view_scale = block.view_scale,
                          .karst_ray_forward = block.ray_forward,
                          .karst_shadow_x = block.shadow_x,
                          .karst_shadow_y = block.shadow_y,
                          .karst_shadow_z = block.shadow_z,
                          .karst_shadow_box_0 = block.shadow_box_0,
                          .karst_shadow_box_1 = block.shadow_box_1,
                          .karst_shadow_box_2 = block.shadow_box_2,
                          .karst_shadow_scale = block.shadow_scale,
                          .karst_water = block.water,
                          .karst_water_wave = {}};
  static_assert(std::size(air.karst_water_wave) == KARST_WAVES);
  std::copy(std::begin(block.water_wave), std::end(block.water_wave), std::begin(air.karst_water_wave));
  return air;
}

void turn_frame_block(shader::FrameBlock& block, int quarter_turns) {
  for (int turn = 0; turn < (quarter_turns & 3); ++turn) {
    // A point at (x, y) of the picture goes to (-y, x).
    for (int column = 0; column < 4; ++column) {
      glm::vec4& c = block.clip_from_lattice[column];
      c = {-c.y, c.x, c.z, c.w};
    }
    const glm::vec4 right = block.ray_right;
    block.ray_right = -block.ray_up;
    block.ray_up = right;
  }
}

}  // namespace karst::core
