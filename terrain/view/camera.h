// SPDX-License-Identifier: MIT
// The camera on the lattice (design 4.3). Its place is an integer: a whole voxel, which is subtracted from
// patch origins in integers, and a fine part in sixteenths of a lattice step, which goes into the view
// matrix. Metres end here: everything behind a Camera is the same bits wherever the world lies and however
// large its voxels are.
//
// Axes: right-handed, y up. Yaw 0 looks along -z and grows to the left (counter-clockwise seen from above);
// pitch grows upwards.
#pragma once

#include <cstdint>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "karst/status.h"
#include "terrain/base/lattice.h"

namespace karst::core {

// Fractions of a lattice step that a camera's place is rounded to. Not finer, because a double resolves 10^7
// m to 1.9e-9 m, which is 1/64 step of a voxel of 1 mm; a place given on this grid still comes out exactly.
// Not coarser, because 1/16 step is 1/131072 voxel: at 1/10 voxel from the eye less than a tenth of a pixel.
inline constexpr int kCameraFractionBits = 4;

// Farthest that a camera may be from the octree's minimum corner, on each axis.
inline constexpr double kCameraReach = 1 << 20;  // voxels; 2,000 times the largest world

// What a user states. Ranges are those that make_camera accepts; all ends are included unless said otherwise.
struct CameraSettings {
  glm::dvec3 position{0.0};    // voxels from the octree's minimum corner, within +-kCameraReach
  double yaw_deg = 0.0;        // -1e6..1e6
  double pitch_deg = 0.0;      // -90..90
  double fov_y_deg = 60.0;     // 1..170, of the picture's whole height
  double aspect = 16.0 / 9;    // 1/64..64, width by height
  double near_voxels = 0.125;  // kLeastNear.. and less than far_voxels; at 1/8 a 24-bit depth buffer still
                               // tells 1/200 voxel apart at 100 voxels
  double far_voxels = 1024.0;  // ..kCameraReach; the default is above the largest world's diagonal, 887
};
inline constexpr double kLeastNear = 1.0 / kStepsPerVoxel;  // voxels; one lattice step

// Where the lattice lies in the user's world: position_m = origin_m + voxel_size_m * voxels.
struct WorldFrame {
  glm::dvec3 origin_m{0.0};   // finite
  double voxel_size_m = 1.0;  // finite, above 0
};

struct Camera {
  glm::ivec3 voxel{0};     // whole voxels from the octree's minimum corner
  glm::vec3 fine{0.0f};    // lattice steps in [0, kStepsPerVoxel), a multiple of 2^-kCameraFractionBits
  double yaw_deg = 0.0;    // -180..180
  double pitch_deg = 0.0;  // as in CameraSettings, like the rest
  double fov_y_deg = 60.0;
  double aspect = 16.0 / 9;
  double near_voxels = 0.125;
  double far_voxels = 1024.0;
};

// Metres to voxels. invalid_argument naming position, origin_m or voxel_size_m where one is not finite, the
// voxel size is not positive, or the result is beyond kCameraReach; voxels is then unchanged.
Status voxels_from_metres(const WorldFrame& frame, glm::dvec3 position_m, glm::dvec3& voxels);

// Rounds to the lattice. invalid_argument naming the first field that is not finite or outside its range;
// camera is then unchanged.
Status make_camera(const CameraSettings& settings, Camera& camera);

// Yaw and pitch that look from eye to target (same space, any unit); yaw is 0 straight up and down.
// invalid_argument naming target where the two coincide or are not finite.
Status look_at(glm::dvec3 eye, glm::dvec3 target, double& yaw_deg, double& pitch_deg);

// Columns: the camera's right, up and backward directions in world axes.
glm::dmat3 world_from_view(const Camera& camera);

// Maps lattice steps relative to the minimum corner of camera.voxel to clip space (OpenGL: -w <= z <= w),
// where w is the distance along the view direction in voxels. Computed in double, rounded to float once.
glm::mat4 clip_from_lattice(const Camera& camera);

// The eye in lattice steps from the octree's minimum corner: exact, and rounded to float.
glm::dvec3 eye_lattice(const Camera& camera);

// The vertical scale of the projection at its centre: how many times its distance a length on the screen's
// height covers. Pixels per radian are picture height / 2 times this.
double projection_scale(const Camera& camera);

}  // namespace karst::core
