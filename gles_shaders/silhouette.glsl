// SPDX-License-Identifier: MIT
// How much of a pixel a neighbour's surface covers where a silhouette runs between them, from the G-buffer
// alone. A. Reshetov, "Morphological Antialiasing", 2009: an edge between two rows of pixels runs straight
// until the silhouette steps to another row; from the middle of a run it is taken to lead to the middle of
// the step at either end. Here surfaces are told apart by distance, not by colour.

const int kEdgeReach = 12;         // pixels to either side that an edge is followed
const float kSurfaceRatio = 0.85;  // of distances; further apart are two surfaces
const float kSurfaceJump = 2.0;    // times as far as on the other side: not one surface at a grazing angle

struct Silhouette {
  ivec2 side;   // towards the neighbour, pixels
  float cover;  // of this pixel, 0..1/2; 0: none
};

float over_w_at(ivec2 place) {
  ivec2 last = ivec2(screen_place.w & 0xffff, screen_place.w >> 16) - 1;
  return uintBitsToFloat(texelFetch(geometry, clamp(place, ivec2(0), last), 0).y);
}

// Area between an edge and the line that goes from half a pixel beside it at the run's end to it at the run's
// middle, in the pixel that is `cells` from the end.
float area_beside(int cells, float half_run) {
  float a = float(cells);
  float b = min(a + 1.0, half_run);
  return b > a ? 0.5 * (b - a) - 0.25 * (b * b - a * a) / half_run : 0.0;
}

float cover_from(ivec2 place, ivec2 side, float here, float there) {
  float middle = 0.5 * (here + there);
  bool nearer = here > there;
  ivec2 run = ivec2(kEdgeReach);
  bvec2 steps_here = bvec2(false);
  for (int end = 0; end < 2; ++end) {
    ivec2 onward = end == 0 ? side.yx : -side.yx;
    ivec2 at = place;
    for (int cells = 0; cells < kEdgeReach; ++cells) {
      at += onward;
      bool ends_here = (over_w_at(at) > middle) != nearer;
      bool ends_there = (over_w_at(at + side) > middle) == nearer;
      if (!ends_here && !ends_there) continue;
      run[end] = cells;
      steps_here[end] = !ends_there;
      break;
    }
  }
  float half_run = 0.5 * float(run.x + run.y + 1);
  return (steps_here.x ? area_beside(run.x, half_run) : 0.0) +
         (steps_here.y ? area_beside(run.y, half_run) : 0.0);
}

// here: 1 / w of the pixel, 0 for the sky.
Silhouette silhouette_at(ivec2 place, float here) {
  Silhouette best = Silhouette(ivec2(0), 0.0);
  vec4 around = vec4(over_w_at(place + ivec2(1, 0)), over_w_at(place - ivec2(1, 0)),
                     over_w_at(place + ivec2(0, 1)), over_w_at(place - ivec2(0, 1)));
  vec4 jump = abs(around - here);
  bvec4 other = lessThan(min(around, here), kSurfaceRatio * max(around, here));
  if (!any(other)) return best;
  for (int axis = 0; axis < 4; axis += 2) {
    int n = jump[axis] < jump[axis + 1] ? axis + 1 : axis;
    float there = around[n];
    bool sky = min(here, there) == 0.0;
    if (!other[n] || (sky ? (screen_place.z & 1) == 0 : jump[n] < kSurfaceJump * jump[n ^ 1])) continue;
    ivec2 side = (axis == 0 ? ivec2(1, 0) : ivec2(0, 1)) * (n == axis ? 1 : -1);
    float cover = cover_from(place, side, here, there);
    if (cover > best.cover) best = Silhouette(side, cover);
  }
  return best;
}
