// SPDX-License-Identifier: MIT
#include "renderer/gl/gpu_timer.h"

#include <limits>

namespace karst::core {

void GpuTimer::create(const Gl& gl, const GlCaps& caps) {
  supported_ = caps.timer_query;
  desktop_ = caps.desktop;
  if (!supported_) return;
  gl.GenQueriesEXT(kQueries, queries_);
  if (caps.first_timer_result_is_wrong) waste_result(gl);
  begun_ = 0;
  collected_ = 0;
  latest_ms_ = -1;
}

// A query over nothing would not get the wrong result, so something is drawn into.
void GpuTimer::waste_result(const Gl& gl) {
  GLuint texture = 0;
  GLuint framebuffer = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT24, 1, 1);
  gl.GenFramebuffers(1, &framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture, 0);
  begin(gl);
  const GLfloat far = 1.0f;
  gl.ClearBufferfv(GL_DEPTH, 0, &far);
  end(gl);
  gl.Finish();
  collect(gl);
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  gl.DeleteFramebuffers(1, &framebuffer);
  gl.DeleteTextures(1, &texture);
}

void GpuTimer::destroy(const Gl& gl) {
  if (supported_) gl.DeleteQueriesEXT(kQueries, queries_);
  forget();
}

void GpuTimer::forget() {
  supported_ = false;
  running_ = false;
  begun_ = 0;
  collected_ = 0;
}

void GpuTimer::begin(const Gl& gl) {
  if (!supported_ || begun_ - collected_ == kQueries) return;
  gl.BeginQueryEXT(GL_TIME_ELAPSED_EXT, queries_[begun_ % kQueries]);
  running_ = true;
}

void GpuTimer::end(const Gl& gl) {
  if (!running_) return;
  gl.EndQueryEXT(GL_TIME_ELAPSED_EXT);
  running_ = false;
  ++begun_;
}

double GpuTimer::latest_ms(const Gl& gl) {
  if (supported_) collect(gl);
  return latest_ms_ < 0 ? std::numeric_limits<double>::quiet_NaN() : latest_ms_;
}

void GpuTimer::collect(const Gl& gl) {
  while (collected_ < begun_) {
    const GLuint query = queries_[collected_ % kQueries];
    GLuint available = GL_FALSE;
    gl.GetQueryObjectuivEXT(query, GL_QUERY_RESULT_AVAILABLE_EXT, &available);
    if (available == GL_FALSE) return;
    GLuint64 elapsed_ns = 0;
    gl.GetQueryObjectui64vEXT(query, GL_QUERY_RESULT_EXT, &elapsed_ns);
    ++collected_;
    // After a disjoint operation (a change of the clock's rate) results mean nothing; reading clears the
    // flag.
    GLint disjoint = GL_FALSE;
    if (!desktop_) gl.GetIntegerv(GL_GPU_DISJOINT_EXT, &disjoint);
    if (disjoint == GL_FALSE) latest_ms_ = static_cast<double>(elapsed_ns) * 1e-6;
  }
}

}  // namespace karst::core
