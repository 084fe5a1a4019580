// SPDX-License-Identifier: MIT
// The camera on the lattice (design 4.3). Its place is an integer: a whole voxel, which is subtracted from
// patch origins in integers, and a fine part in sixteenths of a lattice step, which goes into the view
// matrix. Metres end here: everything behind a Camera is the same bits wherever the world lies and however
// large its voxels are.
//
// Axes: right-handed, y up. View space: x to the right, y up, looking along -z, in voxels from the eye. Yaw 0
// looks along -z and grows to the left (counter-clockwise seen from above); pitch grows upwards; roll grows
// to the right (the right side goes down).
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
// As fine as a float can hold, for worlds on curved bases: their voxels may be as large as a country.
inline constexpr int kFinestCameraFractionBits = 11;

// Farthest that a camera may be from the octree's minimum corner, on each axis.
inline constexpr double kCameraReach = 1 << 20;  // voxels; 2,000 times the largest world

// A camera in angles. Ranges are those that make_camera accepts; all ends are included unless said otherwise.
struct CameraSettings {
  glm::dvec3 position{0.0};    // voxels from the octree's minimum corner, within +-kCameraReach
  double yaw_deg = 0.0;        // -1e6..1e6
  double pitch_deg = 0.0;      // -90..90
  double roll_deg = 0.0;       // -1e6..1e6
  double fov_y_deg = 60.0;     // 1..170, of the picture's whole height
  double aspect = 16.0 / 9;    // 1/64..64, width by height
  double near_voxels = 0.125;  // kLeastNear.. and less than far_voxels; at 1/8 a 24-bit depth buffer still
                               // tells 1/200 voxel apart at 100 voxels
  double far_voxels = 1024.0;  // ..kCameraReach; the default is above the largest world's diagonal, 887
  bool reversed_depth = false;
};
inline constexpr double kLeastNear = 1.0 / kStepsPerVoxel;  // voxels; one lattice step

// A camera in matrices: any rotation, mirrored or not, and any perspective or parallel projection.
// make_camera says what is refused.
struct CameraMatrices {
  glm::dvec3 position{0.0};                 // the view's origin, as in CameraSettings
  glm::dmat3 view_from_world{1.0};          // orthonormal within kRotationSlack; determinant -1: mirrored
  glm::dmat4 clip_from_view{1.0};           // OpenGL: what is seen has -w <= x, y, z <= w
  bool reversed_depth = false;              // z / w is 1 at the near plane and falls with distance
  int fraction_bits = kCameraFractionBits;  // ..kFinestCameraFractionBits
};
inline constexpr double kRotationSlack = 1e-5;     // of a product of two rows
inline constexpr double kWidestCorner = 1 << 10;   // tangent of the angle between forward and a corner
inline constexpr double kNarrowestView = 1 << 20;  // most times its distance, or a voxel, that half a picture
                                                   // covers
inline constexpr double kLeastMatrixNear = 0x1p-24;  // voxels

// Where the lattice lies in the user's world: position_m = origin_m + voxel_size_m * voxels.
struct WorldFrame {
  glm::dvec3 origin_m{0.0};   // finite
  double voxel_size_m = 1.0;  // finite, above 0
};

inline constexpr double kDefaultScale = 1.7320508075688772;  // 1 / tan 30 degrees

// Made by make_camera; the members after reversed_depth follow from those before. The default looks north
// with CameraSettings' defaults.
struct Camera {
  glm::ivec3 voxel{0};              // whole voxels from the octree's minimum corner
  glm::vec3 fine{0.0f};             // lattice steps in [0, kStepsPerVoxel), a multiple of 2^-fraction_bits
  glm::dmat3 view_from_world{1.0};  // orthonormal
  // Of a perspective: its centre is the eye, and w is the distance along forward in voxels. Parallel: w is 1.
  glm::dmat4 clip_from_view{kDefaultScale * 9 / 16,
                            0,
                            0,
                            0,
                            0,
                            kDefaultScale,
                            0,
                            0,
                            0,
                            0,
                            -(1024.0 + 0.125) / (1024.0 - 0.125),
                            -1,
                            0,
                            0,
                            -2.0 * 1024.0 * 0.125 / (1024.0 - 0.125),
                            0};
  bool reversed_depth = false;  // nearer has the greater depth; the depth buffer is cleared to 0

  bool parallel = false;  // the eye is only what distances are measured from
  bool mirrored = false;  // what faces the eye is clockwise in the picture
  // World axes, unit length: where w grows, or along which a parallel view looks.
  glm::dvec3 forward{0.0, 0.0, -1.0};
  // Least and most distance from the eye, along forward, of what is in view. near_voxels is above 0 unless
  // parallel; far_voxels may be infinite.
  double near_voxels = 0.125;
  double far_voxels = 1024.0;
};

// Metres to voxels. invalid_argument naming position, origin_m or voxel_size_m where one is not finite, the
// voxel size is not positive, or the result is beyond kCameraReach; voxels is then unchanged.
Status voxels_from_metres(const WorldFrame& frame, glm::dvec3 position_m, glm::dvec3& voxels);

// Rounds to the lattice. invalid_argument naming the first field that is not finite or outside its range;
// camera is then unchanged.
Status make_camera(const CameraSettings& settings, Camera& camera);

// The same from matrices. The rotation is made exactly orthonormal. The centre of a perspective need not be
// the view's origin: the camera's place is the centre. invalid_argument naming
//  position: not within kCameraReach, or a perspective's centre is not;
//  view_from_world: not finite or not orthonormal;
//  clip_from_view: not finite; not invertible, or so nearly that it can't be told; a corner beyond
//  kWidestCorner, a picture narrower than kNarrowestView; nothing in front of the eye is between the near and
//  the far plane, or the near plane is nearer than kLeastMatrixNear;
//  reversed_depth: depth runs the other way.
Status make_camera(const CameraMatrices& matrices, Camera& camera);

// Yaw and pitch that look from eye to target (same space, any unit); yaw is 0 straight up and down.
// invalid_argument naming target where the two coincide or are not finite.
Status look_at(glm::dvec3 eye, glm::dvec3 target, double& yaw_deg, double& pitch_deg);

// Columns: view space's axes (right, up, backward) in world axes.
glm::dmat3 world_from_view(const Camera& camera);

// The linear part of clip coordinate r (0..3: x, y, z, w) in world axes, per voxel.
glm::dvec3 clip_row(const Camera& camera, int r);

// Maps lattice steps relative to the minimum corner of camera.voxel to clip space (OpenGL: -w <= z <= w).
// Computed in double, rounded to float once.
glm::mat4 clip_from_lattice(const Camera& camera);

// The eye in lattice steps from the octree's minimum corner: exact, and rounded to float.
glm::dvec3 eye_lattice(const Camera& camera);

}  // namespace karst::core
