// SPDX-License-Identifier: MIT
#include "renderer/gl/gpu_timer.h"

#include <limits>

namespace karst::core {

void GpuTimer::create(const Gl& gl, const GlCaps& caps) {
  supported_ = caps.timer_query;
  if (!supported_) return;
  gl.GenQueriesEXT(kQueries, queries_);
  if (caps.first_timer_result_is_wrong) {
    begin(gl);
    gl.Clear(GL_DEPTH_BUFFER_BIT);  // a query over nothing would not get the wrong result
    end(gl);
    gl.Finish();
    collect(gl);
  }
  begun_ = 0;
  collected_ = 0;
  latest_ms_ = -1;
}

void GpuTimer::destroy(const Gl& gl) {
  if (supported_) gl.DeleteQueriesEXT(kQueries, queries_);
  supported_ = false;
  running_ = false;
  begun_ = 0;
  collected_ = 0;
}

void GpuTimer::begin(const Gl& gl) {
  if (!supported_) return;
  collect(gl);
  if (begun_ - collected_ == kQueries) return;
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
    gl.GetIntegerv(GL_GPU_DISJOINT_EXT, &disjoint);
    if (disjoint == GL_FALSE) latest_ms_ = static_cast<double>(elapsed_ns) * 1e-6;
  }
}

}  // namespace karst::core
