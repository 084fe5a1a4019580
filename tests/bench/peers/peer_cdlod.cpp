// SPDX-License-Identifier: MIT
// F. Strugar, "Continuous Distance-Dependent Level of Detail for Rendering Heightmaps" (2009), on the peers'
// scene: a quadtree whose nodes all draw one grid, chosen by ranges that double from level to level (4.2),
// and vertices that slide to the grid of the level above over the last part of a range (4.3). Heights and
// normals come from one texture in the vertex shader; light is a vertex's. Usage: peer_cdlod [range of the
// finest level, metres] [quads of a node's side] [dump]
#include "tests/bench/peers/gles_peer.h"

namespace {

using namespace peer;

constexpr char kVertex[] = R"(
layout(location = 0) in vec2 grid;   // 0..1
uniform sampler2D ground;            // height, normal's x, z
uniform vec4 node;                   // first sample, samples of its side, quads of its side
uniform vec2 morph;                  // distances from which and to which vertices slide
uniform vec3 eye;
const float kCell = 4000.0 / 1024.0;
vec3 sample_at(vec2 at) { return textureLod(ground, (at + 0.5) / 1025.0, 0.0).xyz; }
void main() {
  vec2 at = node.xy + grid * node.z;
  vec3 far = vec3(at.x * kCell - 2000.0, sample_at(at).x, at.y * kCell - 2000.0);
  float share = clamp((distance(far, eye) - morph.x) / (morph.y - morph.x), 0.0, 1.0);
  vec2 odd = fract(grid * node.w * 0.5) * 2.0 / node.w;
  at -= odd * node.z * share;
  vec3 height = sample_at(at);
  shade(vec3(at.x * kCell - 2000.0, height.x, at.y * kCell - 2000.0), height.yz);
}
)";
constexpr double kMorphStart = 0.66;  // of the range of a level beyond the finer one's, as the paper has it

class Cdlod {
 public:
  Cdlod(const Heightmap& map, float range_m, int side) : ground_(map), side_(side) {
    for (int width = kN - 1; width >= side; width /= 2) ++levels_;
    for (int level = 0; level < levels_; ++level) ranges_.push_back(range_m * static_cast<float>(1 << level));
    // All is drawn, however far.
    ranges_.back() = 1e6f;
    make_bounds();
    make_texture();
    make_grid();
  }

  Drawn draw(GLuint program, int frame, const float clip_from_world[16]) {
    const V3 eye = eye_at(frame);
    eye_[0] = static_cast<float>(eye.x), eye_[1] = static_cast<float>(eye.y),
    eye_[2] = static_cast<float>(eye.z);
    const Planes planes(clip_from_world);
    chosen_.clear();
    choose(planes, levels_ - 1, 0, 0);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glUniform1i(glGetUniformLocation(program, "ground"), 1);
    glUniform3fv(glGetUniformLocation(program, "eye"), 1, eye_);
    const GLint node_at = glGetUniformLocation(program, "node");
    const GLint morph_at = glGetUniformLocation(program, "morph");
    glBindVertexArray(grid_);
    Drawn drawn;
    int last = -1;
    for (const Chosen& c : chosen_) {
      if (c.level != last) {
        const float end = ranges_[static_cast<std::size_t>(c.level)];
        const float start = c.level == 0 ? 0 : ranges_[static_cast<std::size_t>(c.level) - 1];
        glUniform2f(morph_at, start + (end - start) * static_cast<float>(kMorphStart), end);
        last = c.level;
      }
      const int width = side_ << c.level;
      glUniform4f(node_at, static_cast<float>(c.x * width), static_cast<float>(c.z * width),
                  static_cast<float>(width), static_cast<float>(side_));
      // Quarters lie behind each other in the indices.
      for (int quadrant = 0; quadrant < 4; ++quadrant) {
        if ((c.quarters >> quadrant & 1) == 0) continue;
        int run = 1;
        while (quadrant + run < 4 && (c.quarters >> (quadrant + run) & 1) != 0) ++run;
        const int indices = 6 * (side_ / 2) * (side_ / 2);
        glDrawElements(GL_TRIANGLES, run * indices, GL_UNSIGNED_SHORT,
                       reinterpret_cast<const void*>(static_cast<std::uintptr_t>(2 * quadrant * indices)));
        drawn.triangles += run * indices / 3;
        ++drawn.draws;
        quadrant += run - 1;
      }
    }
    return drawn;
  }

 private:
  struct Bounds {
    float low = 1e9f, high = -1e9f;
  };
  struct Chosen {
    int level, x, z;
    int quarters;  // bit n: that one is drawn: bit 0 of n east, bit 1 south
  };

  std::size_t across(int level) const { return static_cast<std::size_t>((kN - 1) / (side_ << level)); }

  void make_bounds() {
    for (int level = 0; level < levels_; ++level) {
      const std::size_t n = across(level);
      std::vector<Bounds>& own = bounds_.emplace_back(n * n);
      for (std::size_t z = 0; z < n; ++z) {
        for (std::size_t x = 0; x < n; ++x) {
          Bounds& b = own[z * n + x];
          if (level > 0) {
            for (int q = 0; q < 4; ++q) {
              const Bounds& child = bounds_[static_cast<std::size_t>(level) - 1]
                                           [(2 * z + static_cast<std::size_t>(q >> 1)) * 2 * n + 2 * x +
                                            static_cast<std::size_t>(q & 1)];
              b.low = std::min(b.low, child.low);
              b.high = std::max(b.high, child.high);
            }
            continue;
          }
          for (int k = 0; k <= side_; ++k) {
            for (int i = 0; i <= side_; ++i) {
              const float h =
                  ground_.height(static_cast<int>(x) * side_ + i, static_cast<int>(z) * side_ + k);
              b.low = std::min(b.low, h);
              b.high = std::max(b.high, h);
            }
          }
        }
      }
    }
  }

  void make_texture() {
    std::vector<float> texels(std::size_t{kN} * kN * 4);
    for (int j = 0; j < kN; ++j) {
      for (int i = 0; i < kN; ++i) {
        float* const to = texels.data() + (std::size_t(j) * kN + std::size_t(i)) * 4;
        const auto slope = ground_.normal(i, j, 1);
        to[0] = ground_.height(i, j);
        to[1] = slope[0];
        to[2] = slope[1];
      }
    }
    if (std::strstr(reinterpret_cast<const char*>(glGetString(GL_EXTENSIONS)), "OES_texture_float_linear") ==
        nullptr)
      fail("needs OES_texture_float_linear");
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, kN, kN, 0, GL_RGBA, GL_FLOAT, texels.data());
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  }

  void make_grid() {
    std::vector<float> places;
    for (int k = 0; k <= side_; ++k) {
      for (int i = 0; i <= side_; ++i) {
        places.push_back(static_cast<float>(i) / static_cast<float>(side_));
        places.push_back(static_cast<float>(k) / static_cast<float>(side_));
      }
    }
    std::vector<std::uint16_t> indices;
    const int half = side_ / 2;
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      for (int k = quadrant / 2 * half; k < (quadrant / 2 + 1) * half; ++k) {
        for (int i = quadrant % 2 * half; i < (quadrant % 2 + 1) * half; ++i) {
          const auto at = [&](int di, int dk) {
            return static_cast<std::uint16_t>((k + dk) * (side_ + 1) + i + di);
          };
          indices.insert(indices.end(), {at(0, 0), at(0, 1), at(1, 0), at(1, 0), at(0, 1), at(1, 1)});
        }
      }
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

  bool in_range(const float low[3], const float high[3], float range) const {
    float sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float d = std::max({low[axis] - eye_[axis], eye_[axis] - high[axis], 0.0f});
      sum += d * d;
    }
    return sum <= range * range;
  }

  // The paper's LODSelect(): false where the node is out of its level's range, and the parent draws there.
  bool choose(const Planes& planes, int level, int x, int z) {
    const Bounds& b = bounds_[static_cast<std::size_t>(level)]
                             [static_cast<std::size_t>(z) * across(level) + static_cast<std::size_t>(x)];
    const auto metres = [](int sample) { return static_cast<float>(sample * kCell - kWorld / 2); };
    const int width = side_ << level;
    const float low[3] = {metres(x * width), b.low, metres(z * width)};
    const float high[3] = {metres((x + 1) * width), b.high, metres((z + 1) * width)};
    if (!in_range(low, high, ranges_[static_cast<std::size_t>(level)])) return false;
    if (!planes.sees(low, high)) return true;
    if (level == 0 || !in_range(low, high, ranges_[static_cast<std::size_t>(level) - 1])) {
      chosen_.push_back({level, x, z, 15});
      return true;
    }
    int quarters = 0;
    for (int q = 0; q < 4; ++q) {
      if (!choose(planes, level - 1, 2 * x + (q & 1), 2 * z + (q >> 1))) quarters |= 1 << q;
    }
    if (quarters != 0) chosen_.push_back({level, x, z, quarters});
    return true;
  }

  Ground ground_;
  int side_;
  int levels_ = 0;
  std::vector<float> ranges_;
  std::vector<std::vector<Bounds>> bounds_;
  std::vector<Chosen> chosen_;
  float eye_[3] = {};
  GLuint texture_ = 0, grid_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  Bench bench;
  const float range_m = argc > 1 ? std::strtof(argv[1], nullptr) : 200;
  const int side = argc > 2 ? std::atoi(argv[2]) : 32;
  if (!(range_m > 0) || (side != 8 && side != 16 && side != 32 && side != 64))
    fail("usage: peer_cdlod RANGE 8|16|32|64 [dump]");
  const Heightmap map = load_heightmap();
  open_context();
  const Programs programs(kVertex);
  Cdlod cdlod(map, range_m, side);
  run_laps(bench, map, programs,
           "cdlod/" + std::to_string(static_cast<int>(range_m)) + "/" + std::to_string(side), argc > 3,
           [&](GLuint program, int frame, const float m[16]) { return cdlod.draw(program, frame, m); });
  return 0;
}
