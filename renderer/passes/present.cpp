// SPDX-License-Identifier: MIT
#include "renderer/passes/present.h"

#include <utility>

#include "renderer/renderer.h"

namespace karst::core {

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

void Renderer::present() {
  if (!has_picture_) return;
  gl_.BindFramebuffer(GL_READ_FRAMEBUFFER, target_);
  gl_.BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  const GLint width = settings_.width;
  const GLint height = settings_.height;
  gl_.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

}  // namespace karst::core
