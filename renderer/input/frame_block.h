// SPDX-License-Identifier: MIT
// From a camera and a sun to what shaders need of a frame.
#pragma once

#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "renderer/input/shader_interface.h"
#include "terrain/basis/level_view.h"
#include "terrain/field/sky_atlas.h"
#include "terrain/imagery/image_view.h"
#include "terrain/shading/materials.h"
#include "terrain/shadow/cascades.h"
#include "terrain/view/camera.h"

namespace karst::core {

// Light and air of a frame. Colours follow from the sun's height; where it is below the horizon a full moon
// takes over. The distance that haze takes follows from the world's size.
struct FrameLight {
  double sun_azimuth_deg = 230.0;   // -360..360; clockwise seen from above, from north (-z): 90 is east (+x)
  double sun_elevation_deg = 35.0;  // -90..90 above the horizon
  double haze_voxels = 400.0;       // above 0, ..2^24: distance at which 63 % of the light is haze
  // Of a curved basis, in the frame's axes, unit length: towards the sun, whose elevation is then that at the
  // eye. All 0: by azimuth and elevation.
  glm::dvec3 towards{0.0};
  // invalid_argument naming the first field outside its range.
  Status validate() const;
};

// least_cos2: ErrorScale's. sky: of the world's octrees. height: of the picture in pixels. light is valid.
shader::FrameBlock make_frame_block(const Camera& camera, float least_cos2, const FrameLight& light,
                                    const SkyAtlas& sky, int height);

// Towards what shines, unit length: the sun, or after dusk the moon, which is full and stands opposite.
glm::dvec3 light_direction(const FrameLight& light);

// Shadow maps of `size` texels a side, as FitCascades made them for the camera's frame.
void set_cascades(const Camera& camera, const LightSpace& space, std::span<const Cascade> cascades, int size,
                  shader::FrameBlock& block);
// Of a curved basis: what is level for the eye.
struct FrameLevel {
  LevelView view;
  glm::vec3 up{0.0f, 1.0f, 0.0f};  // at the eye
  float dip = 0;                   // sine of the angle by which the horizon is lower than level
  float sky = 1;                   // brightness of the sky at the eye
  float thins = 0;                 // 1 / voxels in which air thins by e; 0: it does not
  float plain_over = 0;            // |q|^2 - 1 of the plain beyond the ground
  bool has_plain = false;
  bool has_water = false;
  float water_height = 0;  // of its level, voxels
  float water_over = 0;    // |q|^2 of the eye less that at its level
};
void set_level(const FrameLevel& level, shader::FrameBlock& block);
// What a pass into a cascade's shadow map needs.
shader::FrameBlock make_cascade_block(const Cascade& cascade);

// At most kMostLights of the lights, for the camera's place. guess_caves: the sun is kept out of caves
// without shadow maps.
void set_lights(const Camera& camera, std::span<const PointLight> lights, bool guess_caves,
                shader::FrameBlock& block);

// An image over the world's content, which begins and ends half a voxel inside its sides (karst-bake pads
// worlds by that much), `repeat` times on each axis.
// A height in lattice steps, from the camera's voxel.
float foot_from(const Camera& camera, std::int64_t height);

void set_drape(glm::ivec3 extent, double repeat, shader::FrameBlock& block);

// Where pixels look for image tiles; view: whose table. places_row: of the page table, where places of nodes
// begin.
void set_images(const ImagePlace& place, std::uint32_t view, int places_row, shader::FrameBlock& block);

// Linear light as the picture shows it: output.glsl without its dither.
glm::vec3 encode_picture(glm::vec3 light);
// The sky at the horizon, linear light: to clear with where no sky is drawn.
glm::vec3 horizon_light(const FrameLight& light);

// What air.glsl's block holds in a view of this block. world: from places less the eye, the host's frame and
// metres, to the world's axes and voxels.
shader::KarstAir make_air_block(const shader::FrameBlock& block, const glm::mat4& world);

// Turns what is drawn with the block counter-clockwise, in steps of 90 degrees, for screens that stand on
// their side. Turning by whole steps only swaps and negates numbers, so that the same points of the lattice
// are drawn, to the bit.
void turn_frame_block(shader::FrameBlock& block, int quarter_turns);

}  // namespace karst::core
