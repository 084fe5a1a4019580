// SPDX-License-Identifier: MIT
// The sphere touches the plane first, and the face if it does so inside it; else one of the edges, which are
// cylinders for its centre, or of the corners, which are spheres (Ericson, "Real-Time Collision Detection",
// 2005, sections 5.1.5, 5.3.2, 5.3.7 and 5.5.6).
#include "terrain/query/sweep.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace karst::core {
namespace {

using glm::dot;
using glm::dvec3;

// The point of a triangle nearest to the origin.
dvec3 nearest_point(const dvec3 (&p)[3]) {
  const dvec3 ab = p[1] - p[0];
  const dvec3 ac = p[2] - p[0];
  const double d1 = -dot(ab, p[0]);
  const double d2 = -dot(ac, p[0]);
  if (d1 <= 0 && d2 <= 0) return p[0];
  const double d3 = -dot(ab, p[1]);
  const double d4 = -dot(ac, p[1]);
  if (d3 >= 0 && d4 <= d3) return p[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return p[0] + d1 / (d1 - d3) * ab;
  const double d5 = -dot(ab, p[2]);
  const double d6 = -dot(ac, p[2]);
  if (d6 >= 0 && d5 <= d6) return p[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return p[0] + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return p[1] + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (p[2] - p[1]);
  }
  const double sum = va + vb + vc;
  return p[0] + vb / sum * ab + vc / sum * ac;
}

// Whether a point of the plane lies in the triangle.
bool covers(const dvec3 (&p)[3], dvec3 area, dvec3 point) {
  for (int k = 0; k < 3; ++k) {
    if (dot(area, glm::cross(p[(k + 1) % 3] - p[k], point - p[k])) < 0) return false;
  }
  return true;
}

// Least t >= 0 with a t^2 + 2 b t + c = 0, where the sphere comes nearer; false: none.
bool first_root(double a, double b, double c, double& t) {
  if (!(a > 0) || b >= 0) return false;
  const double square = b * b - a * c;
  if (square < 0) return false;
  t = (-b - std::sqrt(square)) / a;
  return t >= 0;
}

}  // namespace

bool sweep_triangle(const Segment& segment, double radius, const Triangle& triangle, dvec3 area,
                    const Contact& best, Contact& contact) {
  const double area_length = glm::length(area);
  if (!(area_length > 0)) return false;
  const dvec3 normal = area / area_length;
  const dvec3 way = segment.way;
  const dvec3 p[3] = {triangle.corner[0] - segment.from, triangle.corner[1] - segment.from,
                      triangle.corner[2] - segment.from};
  const double height = -dot(normal, p[0]);  // of the centre above the plane
  const double side = height >= 0 ? 1.0 : -1.0;
  if (std::abs(height) > radius) {
    const double approach = -side * dot(normal, way);
    if (!(approach > 0)) return false;
    const double t = (std::abs(height) - radius) / approach;
    if (!(t <= best.t)) return false;
    const dvec3 point = t * way - side * radius * normal;
    if (covers(p, area, point)) {
      contact = {t, 0.0, segment.from + point};
      return true;
    }
  } else {
    const dvec3 point = nearest_point(p);
    const double distance = glm::length(point);
    if (distance <= radius) {
      contact = {0.0, distance, segment.from + point};
      return true;
    }
  }
  double first = best.t;
  bool found = false;
  const double ww = dot(way, way);
  for (int k = 0; k < 3; ++k) {
    const dvec3 e = p[(k + 1) % 3] - p[k];
    const dvec3 m = -p[k];
    const double ee = dot(e, e);
    const double ew = dot(e, way);
    const double em = dot(e, m);
    const double wm = dot(way, m);
    const double mm = dot(m, m) - radius * radius;
    double t = 0;
    if (first_root(ee * ww - ew * ew, ee * wm - ew * em, ee * mm - em * em, t) && t <= first) {
      const double along = (em + t * ew) / ee;
      if (along >= 0 && along <= 1) {
        first = t;
        found = true;
        contact = {t, 0.0, segment.from + p[k] + along * e};
      }
    }
    if (first_root(ww, wm, mm, t) && t <= first) {
      first = t;
      found = true;
      contact = {t, 0.0, triangle.corner[k]};
    }
  }
  return found;
}

}  // namespace karst::core
