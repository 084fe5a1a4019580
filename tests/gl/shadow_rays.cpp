// SPDX-License-Identifier: MIT
#include "tests/gl/shadow_rays.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/draw/index_batches.h"

namespace karst::test {
using namespace core;
namespace {

constexpr std::uint32_t kChunkIndices = 48;  // 16 triangles

void GL_APIENTRY show_shadows(GLuint shader, GLsizei count, const GLchar* const* texts,
                              const GLint* lengths) {
  std::string text;  // a length below 0: up to the end
  for (GLsizei n = 0; n < count; ++n)
    text +=
        lengths[n] < 0 ? std::string(texts[n]) : std::string(texts[n], static_cast<std::size_t>(lengths[n]));
  const std::size_t main = text.find("void main() {");
  if (main != std::string::npos && text.find("in vec3 from_eye_ws") != std::string::npos &&
      text.find("out vec4 colour") != std::string::npos) {
    text.resize(main);
    text +=
        "void main() {\n"
        "#ifdef KARST_SHADOWS\n"
        "  vec3 normal = normalize(normal_ws);\n"
        "  colour = vec4(sun_reaches(from_eye_ws, normal), dot(normal, sun_direction.xyz), 0.0, 1.0);\n"
        "#else\n"
        "  colour = vec4(0.0, 0.0, 0.0, 1.0);\n"
        "#endif\n"
        "}\n";
  }
  const char* const changed = text.c_str();
  GlContext::get().gl().ShaderSource(shader, 1, &changed, nullptr);
}

}  // namespace

Gl showing_shadows() {
  Gl gl = GlContext::get().gl();
  gl.ShaderSource = show_shadows;
  return gl;
}

struct Triangles::Ray {
  glm::dvec3 from, direction, inverse;
  double beyond;
};

Triangles::Triangles(DrawnWorld& drawn) : tree_(&drawn.world().tree()) {
  const World& world = drawn.world();
  const int level = world.info().level;
  const auto a_patch = static_cast<std::size_t>(patch_vertices(level));
  IndexRange ranges[kMaxIndexRanges];
  EXPECT_EQ(index_ranges(level, 0, 0, ranges), 1);
  const auto table = world.index_table().subspan(ranges[0].first, ranges[0].count);
  table_.assign(table.begin(), table.end());
  chunks_a_patch_ = (ranges[0].count + kChunkIndices - 1) / kChunkIndices;
  std::vector<GpuVertex> vertices(a_patch);
  const Surface surface = world.surface();
  for (PatchId p = 0; p < world.patch_count(); ++p) {
    EXPECT_TRUE(drawn.residency().generate(p, level, level, vertices).ok());
    const auto first_vertex = static_cast<std::uint32_t>(vertices_.size());
    const glm::ivec3 origin = patch_origin(surface.volume_of(p));
    for (const GpuVertex& v : vertices) {
      vertices_.push_back(glm::vec3(origin + glm::ivec3(v.position[0], v.position[1], v.position[2])) /
                          static_cast<float>(kStepsPerVoxel));
    }
    for (std::uint32_t first = 0; first < ranges[0].count; first += kChunkIndices) {
      Chunk chunk;
      chunk.first_vertex = first_vertex;
      chunk.first_index = first;
      chunk.indices = std::min(kChunkIndices, ranges[0].count - first);
      for (std::uint32_t n = 0; n < chunk.indices; ++n) {
        const glm::dvec3 at(vertices_[first_vertex + table_[first + n]]);
        chunk.box.low = glm::min(chunk.box.low, at);
        chunk.box.high = glm::max(chunk.box.high, at);
      }
      chunks_.push_back(chunk);
    }
  }
}

bool Triangles::reaches(const Ray& ray, const Box& box, double nearest) {
  const glm::dvec3 a = (box.low - ray.from) * ray.inverse;
  const glm::dvec3 b = (box.high - ray.from) * ray.inverse;
  const glm::dvec3 first = glm::min(a, b);
  const glm::dvec3 last = glm::max(a, b);
  const double end = std::min({last.x, last.y, last.z, nearest});
  return std::max({first.x, first.y, first.z, ray.beyond}) <= end;
}

void Triangles::visit(const Ray& ray, int row, std::uint32_t n, double& nearest, bool any) const {
  if (any && nearest < 1e9) return;
  if (row >= 0) {
    const LatticeBox& node = tree_->node(row, n);
    const double unit = kStepsPerVoxel;
    if (!reaches(ray, {glm::dvec3(node.min) / unit, glm::dvec3(node.max) / unit}, nearest)) return;
    const std::uint32_t count = row > 0 ? tree_->nodes(row - 1) : tree_->patches();
    const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, count);
    for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child)
      visit(ray, row - 1, child, nearest, any);
    return;
  }
  for (std::uint32_t c = n * chunks_a_patch_; c < (n + 1) * chunks_a_patch_; ++c) {
    const Chunk& chunk = chunks_[c];
    if (!reaches(ray, chunk.box, nearest)) continue;
    for (std::uint32_t i = 0; i < chunk.indices; i += 3) {
      // T. Moeller, B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
      glm::dvec3 t[3];
      for (std::uint32_t k = 0; k < 3; ++k) {
        t[k] = glm::dvec3(vertices_[chunk.first_vertex + table_[chunk.first_index + i + k]]);
      }
      const glm::dvec3 u = t[1] - t[0];
      const glm::dvec3 v = t[2] - t[0];
      const glm::dvec3 p = glm::cross(ray.direction, v);
      const double determinant = glm::dot(u, p);
      if (std::abs(determinant) < 1e-15) continue;
      const glm::dvec3 s = ray.from - t[0];
      const double a = glm::dot(s, p) / determinant;
      const glm::dvec3 q = glm::cross(s, u);
      const double b = glm::dot(ray.direction, q) / determinant;
      const double distance = glm::dot(v, q) / determinant;
      if (a >= 0 && b >= 0 && a + b <= 1 && distance > ray.beyond) nearest = std::min(nearest, distance);
    }
  }
}

double Triangles::first_hit(glm::dvec3 from, glm::dvec3 direction, double beyond) const {
  double nearest = 1e9;
  visit({from, direction, 1.0 / direction, beyond}, tree_->rows() - 1, 0, nearest, false);
  return nearest < 1e9 ? nearest : -1;
}

bool Triangles::hit(glm::dvec3 from, glm::dvec3 direction, double beyond) const {
  double nearest = 1e9;
  visit({from, direction, 1.0 / direction, beyond}, tree_->rows() - 1, 0, nearest, true);
  return nearest < 1e9;
}

ShadowedWorld::ShadowedWorld(std::span<const std::byte> file, const Gl& gl, test::DrawnSettings settings)
    : drawn(file, gl, settings) {
  drawn.lod.mode = LodMode::full;
  fit.settings.count = settings.cascades;
  fit.settings.size = settings.shadow_size;
}

ShadowedWorld::ShadowedWorld(const TestWorld& world, const Gl& gl, test::DrawnSettings settings)
    : ShadowedWorld(std::span<const std::byte>(world.file()), gl, settings) {
  fit.settings.reach_voxels = 64;
}

void ShadowedWorld::draw(const CameraSettings& settings, FrameCounts* counts) {
  ViewInput input;
  ASSERT_TRUE(drawn.prepare(settings, input).ok());
  fit.camera = &input.camera;
  fit.to_sun = light_direction(drawn.light);
  fit.world = drawn.world().box();
  fit.light = &light;
  fit.cascades = cascades;
  ASSERT_TRUE(fit.validate().ok());
  fit.run();
  input.light_space = light;
  input.cascades = std::span(cascades).first(static_cast<std::size_t>(fit.settings.count));
  const DrawItem* items = input.items.data();
  caster_triangles = 0;
  for (int n = 0; n < fit.settings.count; ++n) {
    CascadeInput cascade;
    cascade.cascade = cascades[n];
    ShadowCasters::Result casters;
    ASSERT_TRUE(
        drawn.casters()
            .select(drawn.world(), drawn.residency(), drawn.view(), cascade.cascade, error_texels, 1, casters)
            .ok());
    cascade.first_morph_row = input.first_morph_row;
    EXPECT_EQ(casters.lacking, 0u);
    hashes[n] = casters.hash;
    caster_triangles += casters.triangles;
    cascade.items = casters.items;
    cascade.pages = input.pages;
    cascade.index_table = input.index_table;
    cascade.max_level = input.max_level;
    ASSERT_TRUE(drawn.renderer().draw_cascade(n, cascade).ok());
  }
  EXPECT_EQ(items, input.items.data());
  ASSERT_TRUE(drawn.draw(input, counts).ok());
}

std::vector<glm::dvec3> points_behind(app::PictureTarget& target, const CameraSettings& settings) {
  const int width = target.settings().width;
  const int height = target.settings().height;
  std::vector<float> depth(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  EXPECT_TRUE(target.read_depth(depth).ok());
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  const glm::dmat3 axes = world_from_view(camera);
  const double near = camera.near_voxels;
  const double far = camera.far_voxels;
  std::vector<glm::dvec3> points;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double d = depth[points.size()];
      const double z = near * far / (far - d * (far - near));
      const double right = (2 * (x + 0.5) / width - 1) * z / camera.clip_from_view[0][0];
      const double up = (1 - 2 * (y + 0.5) / height) * z / camera.clip_from_view[1][1];
      points.push_back(d == 1
                           ? glm::dvec3(1e9)
                           : eye_lattice(camera) / double{kStepsPerVoxel} + axes * glm::dvec3(right, up, -z));
    }
  }
  return points;
}

void judge(ShadowedWorld& world, const Triangles& triangles, const CameraSettings& camera,
           double border_texels, std::size_t stride, Tally& tally) {
  world.draw(camera);
  const Picture picture = world.drawn.picture();
  const std::vector<glm::dvec3> points = points_behind(world.drawn.target(), camera);
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const glm::dvec3 p = points[i];
    const double facing = picture[i * 4 + 1] / 255.0;
    if (p.x > 1e8 || facing < 0.15) continue;
    const glm::dvec2 at(glm::dot(world.light.x, p), glm::dot(world.light.y, p));
    const auto covers = [&](const Cascade& c) {
      const glm::dvec2 from_middle = glm::abs((at - c.low) / c.side - 0.5);
      return std::max(from_middle.x, from_middle.y) < 0.5 - double{kCascadeBorder} / world.fit.settings.size;
    };
    int used = 0;
    while (used < world.fit.settings.count && !covers(world.cascades[used])) ++used;
    ASSERT_LT(used, world.fit.settings.count);
    const double texel = world.cascades[used].texel;
    const glm::dvec3 sun = world.light.z;
    // Beside the point the ray begins above what the surface can rise to there.
    const double rise =
        1.5 * border_texels * texel * std::sqrt(std::max(1 - facing * facing, 0.0)) / facing + 0.02;
    const bool hit = triangles.hit(p, sun, 0.02);
    bool same = true;
    for (int n = 0; n < 9 && same; ++n) {
      const glm::dvec3 beside =
          (world.light.x * double(n % 3 - 1) + world.light.y * double(n / 3 - 1)) * (border_texels * texel);
      same = triangles.hit(p + beside, sun, rise) == hit;
    }
    if (!same) continue;
    const double reached = picture[i * 4] / 255.0;
    ++tally.judged;
    tally.shaded += hit ? 1 : 0;
    tally.wrong += (reached < 0.5) != hit ? 1 : 0;
    tally.acne += !hit && reached < 0.9 ? 1 : 0;
  }
}

}  // namespace karst::test
