// SPDX-License-Identifier: MIT
// What the public headers share: places, the simulator's frame, and what a simulator lends to karst.
#pragma once

#include <cstddef>
#include <cstdint>

namespace karst {

struct Vec3 {
  double x = 0, y = 0, z = 0;
};

// Pixels, from the bottom left as OpenGL counts them.
struct Rect {
  std::int32_t x = 0, y = 0, width = 0, height = 0;
};

// --- Where the world lies for the simulator. A world file has axes and a zero point of its own: metres to
// the east, up and to the south. All places and directions of the public headers are in the simulator's
// frame.

// Right-handed frames. Named by what x, y and z point to.
enum class Axes : std::uint8_t { east_up_south, east_north_up, north_east_down };

struct Placement {
  Axes axes = Axes::east_north_up;
  Vec3 origin{};        // of the world's zero point, in the simulator's frame, metres; finite, within +-1e12
  double turn_deg = 0;  // of the world's north, clockwise seen from above, -360..360: grid convergence
};

// --- Where places lie on the earth.

// What a world's ground lies on: a plane; longitude and latitude on an ellipsoid; six faces of a cube around
// it, a whole planet; a cylinder; what a function of the host says.
enum class Basis : std::uint8_t { plane, geographic, cube, cylinder, function };

// Where the host puts a ground whose basis is Basis::function (karst-bake --basis function:RADIUS). u, v:
// metres to the east and to the south of its middle. Places are metres in the world's own axes: to the east,
// up and to the south. At height 0 places are no further apart than u and v are, and no radius of curvature
// is less than RADIUS. All give the same bits for the same numbers, from any thread. Materials' heights, haze
// and walls know what is level at the eye alone: such a ground has no walls.
struct GroundFunction {
  Vec3 (*place)(void* user, double u, double v, double height_m) = nullptr;
  Vec3 (*up)(void* user, double u, double v) = nullptr;  // unit length
  // Of what is near the ground; false: none. Null: queries by place find nothing.
  bool (*inverse)(void* user, Vec3 place_m, double& u, double& v, double& height_m) = nullptr;
  void* user = nullptr;
};

// In the datum of the elevation that the world was made from. Altitude: as its heights, which stand above the
// ellipsoid where the basis is one.
struct Geodetic {
  double longitude_deg = 0;  // -180..180
  double latitude_deg = 0;   // -90..90
  double altitude_m = 0;
};

// Of a projected or geographic coordinate reference system: to the east and to the north, in its units.
struct Projected {
  double east = 0, north = 0;
  double height_m = 0;
};

// Directions at a place, of unit length.
struct LocalAxes {
  Vec3 east, up, north;
};

// --- What the simulator lends: a function and its context. All must outlive what they were given to.

enum class Severity : std::uint8_t { note, warning, error };

// text: one line, zero-terminated, valid during the call. May be called from any thread that calls karst.
struct Log {
  void (*line)(void* user, Severity severity, const char* text) = nullptr;
  void* user = nullptr;
};

// A world file, or whatever holds its bytes. read() fills out with [offset, offset + count), never beyond
// bytes, and returns false where it cannot. Any thread that calls karst may call it, and, where
// a world has a ground, one of karst's own; several at a time.
struct Source {
  std::uint64_t bytes = 0;
  bool (*read)(void* user, std::uint64_t offset, std::byte* out, std::size_t count) = nullptr;
  void* user = nullptr;
};

// Addresses of OpenGL functions by name, null where there is none; eglGetProcAddress behind a function will
// do.
struct GlLoader {
  void (*(*load)(void* user, const char* name))() = nullptr;
  void* user = nullptr;
};

// When pixels are shaded, of views that Needs::deferred_width has room for.
enum class Shading : std::uint8_t {
  automatic,  // deferred where a processor renders, or else forward
  forward,    // while they are drawn; there is no G-buffer then
  deferred    // once, from a G-buffer
};

// How much of the textures' detail pixels look up.
enum class Detail : std::uint8_t {
  low,     // albedo and roughness alone: 4 lookups at most, 8 where scales change
  medium,  // and of brightness, height and slopes the nearest mip: 8, or 12
  high     // mips are mixed
};

// Of what mediump is enough for: colours, light, weights.
enum class Precision : std::uint8_t {
  automatic,  // high where a processor renders, which has no arithmetic of 16 bits, or else medium
  medium,
  high  // all of a pixel in 32 bits
};

}  // namespace karst
