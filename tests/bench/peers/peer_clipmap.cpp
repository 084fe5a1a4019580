// SPDX-License-Identifier: MIT
// A. Asirvatham and H. Hoppe, "Terrain Rendering Using GPU-Based Geometry Clipmaps" (GPU Gems 2, chapter 2,
// 2005), on the peers' scene: nested grids of n x n vertices around the eye, each of twice the spacing, drawn
// as rings of twelve blocks with fix-ups and an L in between (2.3); heights of a level in a texture of n x n
// texels, addressed modulo n and updated where the eye has moved to (2.4); heights blend to the next level's
// over the outer tenth (2.3.6). Finest levels that are narrower than 2.5 times the eye's height are left out
// (2.3.4). Normals are in the same texture, light is a vertex's; beyond the scene's sides all vertices lie at
// them.
// Usage: peer_clipmap [n: 63, 127 or 255] [dump]
#include "tests/bench/peers/gles_peer.h"

namespace {

using namespace peer;

constexpr char kVertex[] = R"(
layout(location = 0) in vec2 grid;  // 0 .. n - 1
uniform sampler2D heights;          // own and the next level's, normal's x, z
uniform ivec4 level;                // first vertex in its own spacing, spacing in samples, n
uniform vec3 centre;                // the eye in grid units; of blending
const float kCell = 4000.0 / 1024.0;
void main() {
  ivec2 place = level.xy + ivec2(grid);
  ivec2 texel = place - level.w * ivec2(floor(vec2(place) / float(level.w)));
  vec4 own = texelFetch(heights, texel, 0);
  float width = float(level.w) / 10.0;
  vec2 out_by = (abs(vec2(place) - centre.xy) - (float(level.w - 1) * 0.5 - width - 1.0)) / width;
  float share = clamp(max(out_by.x, out_by.y), 0.0, 1.0);
  vec2 at = clamp(vec2(place * level.z), 0.0, 1024.0) * kCell - 2000.0;
  shade(vec3(at.x, mix(own.x, own.y, share), at.y), own.zw);
}
)";
constexpr double kLeastWidth = 2.5;  // of a level, in heights of the eye over the ground

class Clipmap {
 public:
  Clipmap(const Heightmap& map, int n) : map_(map), ground_(map), n_(n) {
    // All of the scene, wherever the eye is in it.
    for (int spacing = 1;; spacing *= 2) {
      Level& level = levels_.emplace_back();
      level.spacing = spacing;
      glGenTextures(1, &level.texture);
      glBindTexture(GL_TEXTURE_2D, level.texture);
      glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, n, n, 0, GL_RGBA, GL_FLOAT, nullptr);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      if ((n - 1) * spacing >= 2 * kN) break;
    }
    for (const std::uint16_t v : map.v) {
      low_ = std::min(low_, static_cast<float>(v * (kHeight / 65535.0)));
      high_ = std::max(high_, static_cast<float>(v * (kHeight / 65535.0)));
    }
    make_grid();
  }

  Drawn draw(GLuint program, int frame, const float clip_from_world[16]) {
    const V3 eye = eye_at(frame);
    const double x = (eye.x + kWorld / 2) / kCell, z = (eye.z + kWorld / 2) / kCell;
    const double above = eye.y - map_.at(eye.x, eye.z);
    std::size_t finest = 0;
    while (finest + 1 < levels_.size() && (n_ - 1) * levels_[finest].spacing * kCell < kLeastWidth * above)
      ++finest;
    for (std::size_t n = finest; n < levels_.size(); ++n) {
      // Even places: corners lie on vertices of the next level, in the middle of it up to a quad.
      const auto first = [&](double at) {
        return 2 * static_cast<int>(std::floor(at / (2.0 * levels_[n].spacing))) - 2 * ((n_ + 1) / 4 - 1);
      };
      move(levels_[n], first(x), first(z));
    }
    const Planes planes(clip_from_world);
    glUniform1i(glGetUniformLocation(program, "heights"), 1);
    const GLint level_at = glGetUniformLocation(program, "level");
    const GLint centre_at = glGetUniformLocation(program, "centre");
    glBindVertexArray(grid_);
    Drawn drawn;
    for (std::size_t n = finest; n < levels_.size(); ++n) {
      const Level& level = levels_[n];
      glBindTexture(GL_TEXTURE_2D, level.texture);
      glUniform4i(level_at, level.x, level.z, level.spacing, n_);
      glUniform3f(centre_at, static_cast<float>(x / level.spacing), static_cast<float>(z / level.spacing), 0);
      for (const Piece& piece : ring_) draw(level, piece, planes, drawn);
      if (n == finest) {
        draw(level, middle_, planes, drawn);
      } else {
        // On which sides of the hole the finer level leaves a quad's width.
        const int m = (n_ + 1) / 4;
        const int i = levels_[n - 1].x / 2 - level.x - (m - 1);
        const int k = levels_[n - 1].z / 2 - level.z - (m - 1);
        if (i < 0 || i > 1 || k < 0 || k > 1) fail("levels do not nest");
        draw(level, inner_[static_cast<std::size_t>(i + 2 * k)], planes, drawn);
      }
    }
    return drawn;
  }

 private:
  struct Level {
    int spacing = 1;   // samples
    int x = 0, z = 0;  // of its first vertex, in its own spacing
    bool filled = false;
    GLuint texture = 0;
  };
  // Quads that are culled and drawn together.
  struct Piece {
    int i0, k0, i1, k1;  // vertices around them
    std::size_t first;   // of indices
    int count;
  };

  void make_grid() {
    std::vector<float> places;
    for (int k = 0; k < n_; ++k) {
      for (int i = 0; i < n_; ++i) {
        places.push_back(static_cast<float>(i));
        places.push_back(static_cast<float>(k));
      }
    }
    std::vector<std::uint16_t> indices;
    const auto at = [&](int i, int k) { return static_cast<std::uint16_t>(k * n_ + i); };
    const auto add = [&](int i0, int k0, int i1, int k1) {
      for (int k = k0; k < k1; ++k) {
        for (int i = i0; i < i1; ++i) {
          indices.insert(indices.end(), {at(i, k), at(i, k + 1), at(i + 1, k), at(i + 1, k), at(i, k + 1),
                                         at(i + 1, k + 1)});
        }
      }
    };
    const auto piece = [&](int i0, int k0, int i1, int k1, auto fill) {
      const std::size_t first = indices.size();
      fill();
      return Piece{i0, k0, i1, k1, first, static_cast<int>(indices.size() - first)};
    };
    const auto block = [&](int i0, int k0, int i1, int k1) {
      ring_.push_back(piece(i0, k0, i1, k1, [&] { add(i0, k0, i1, k1); }));
    };
    const int m = (n_ + 1) / 4, last = n_ - 1;
    // Sides of blocks along an axis, two quads between the inner two.
    const int from[4] = {0, m - 1, 2 * m, 3 * m - 1};
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        if (row % 3 != 0 && column % 3 != 0) continue;
        block(from[column], from[row], from[column] + m - 1, from[row] + m - 1);
      }
    }
    const int gap = 2 * (m - 1);  // the fix-ups
    block(gap, 0, gap + 2, m - 1);
    block(gap, last - (m - 1), gap + 2, last);
    block(0, gap, m - 1, gap + 2);
    block(last - (m - 1), gap, last, gap + 2);
    // Outermost triangles without area: what is next to them has a vertex at every second of theirs.
    ring_.push_back(piece(0, 0, last, last, [&] {
      for (int i = 0; i < last; i += 2) {
        for (const int k : {0, last}) {
          indices.insert(indices.end(), {at(i, k), at(i + 1, k), at(i + 2, k)});
          indices.insert(indices.end(), {at(k, i), at(k, i + 1), at(k, i + 2)});
        }
      }
    }));
    // The hole: of the finest level all, of others an L on two sides.
    const int low = m - 1, high = last - (m - 1);
    middle_ = piece(low, low, high, high, [&] { add(low, low, high, high); });
    for (int side = 0; side < 4; ++side) {
      inner_[static_cast<std::size_t>(side)] = piece(low, low, high, high, [&] {
        const int column = (side & 1) != 0 ? low : high - 1;
        const int row = (side & 2) != 0 ? low : high - 1;
        add(column, low, column + 1, high);
        // But for the corner.
        add((side & 1) != 0 ? low + 1 : low, row, (side & 1) != 0 ? high : high - 1, row + 1);
      });
    }
    GLuint buffers[2];
    glGenBuffers(2, buffers);
    glGenVertexArrays(1, &grid_);
    glBindVertexArray(grid_);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(places.size() * sizeof(float)), places.data(),
                 GL_STATIC_DRAW);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    glEnableVertexAttribArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * 2), indices.data(),
                 GL_STATIC_DRAW);
  }

  void draw(const Level& level, const Piece& piece, const Planes& planes, Drawn& drawn) const {
    const auto metres = [&](int vertex) {
      return static_cast<float>(std::clamp(vertex * level.spacing, 0, kN - 1) * kCell - kWorld / 2);
    };
    const float low[3] = {metres(level.x + piece.i0), low_, metres(level.z + piece.k0)};
    const float high[3] = {metres(level.x + piece.i1), high_, metres(level.z + piece.k1)};
    if (low[0] == high[0] || low[2] == high[2] || !planes.sees(low, high)) return;
    glDrawElements(GL_TRIANGLES, piece.count, GL_UNSIGNED_SHORT,
                   reinterpret_cast<const void*>(2 * piece.first));
    drawn.triangles += piece.count / 3;
    ++drawn.draws;
  }

  // The level's first vertex; what its texture lacks is uploaded.
  void move(Level& level, int x, int z) {
    if (!level.filled || std::abs(x - level.x) >= n_ || std::abs(z - level.z) >= n_) {
      level.filled = true;
      upload(level, x, z, x + n_, z + n_);
    } else {
      if (x > level.x) upload(level, level.x + n_, z, x + n_, z + n_);
      if (x < level.x) upload(level, x, z, level.x, z + n_);
      if (z > level.z) upload(level, x, level.z + n_, x + n_, z + n_);
      if (z < level.z) upload(level, x, z, x + n_, level.z);
    }
    level.x = x;
    level.z = z;
  }

  // Vertices x0 .. x1 - 1, z0 .. z1 - 1 in the level's spacing, in up to four pieces around the texture's
  // end.
  void upload(const Level& level, int x0, int z0, int x1, int z1) {
    for (int z = z0, next_z; z < z1; z = next_z) {
      next_z = std::min(z1, end_of(z));
      for (int x = x0, next_x; x < x1; x = next_x) {
        next_x = std::min(x1, end_of(x));
        texels_.clear();
        for (int k = z; k < next_z; ++k) {
          for (int i = x; i < next_x; ++i) add_texel(level.spacing, i, k);
        }
        glBindTexture(GL_TEXTURE_2D, level.texture);
        glTexSubImage2D(GL_TEXTURE_2D, 0, modulo(x), modulo(z), next_x - x, next_z - z, GL_RGBA, GL_FLOAT,
                        texels_.data());
      }
    }
  }
  int modulo(int vertex) const { return (vertex % n_ + n_) % n_; }
  int end_of(int vertex) const { return vertex - modulo(vertex) + n_; }

  void add_texel(int spacing, int i, int k) {
    const auto height = [&](int a, int b) { return ground_.height(a * spacing, b * spacing); };
    // The next level's: between the two ends of the edge, or of the diagonal, that the vertex halves.
    const int di = i & 1, dk = k & 1;
    const float coarse = 0.5f * (height(i - di, k + dk) + height(i + di, k - dk));
    const auto slope = ground_.normal(i * spacing, k * spacing, spacing);
    texels_.insert(texels_.end(), {height(i, k), coarse, slope[0], slope[1]});
  }

  const Heightmap& map_;
  Ground ground_;
  int n_;
  float low_ = 1e9f, high_ = -1e9f;
  std::vector<Level> levels_;
  std::vector<Piece> ring_;
  Piece middle_{};
  std::array<Piece, 4> inner_{};  // by where the finer level begins: bit 0 one quad east, bit 1 south
  std::vector<float> texels_;
  GLuint grid_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Bench bench;
  const int n = argc > 1 ? std::atoi(argv[1]) : 255;
  if (n != 63 && n != 127 && n != 255) fail("usage: peer_clipmap 63|127|255 [dump]");
  const Heightmap map = load_heightmap();
  open_context();
  const Programs programs(kVertex);
  Clipmap clipmap(map, n);
  run_laps(bench, map, programs, "clipmap/" + std::to_string(n), argc > 2,
           [&](GLuint program, int frame, const float m[16]) { return clipmap.draw(program, frame, m); });
  return 0;
}
