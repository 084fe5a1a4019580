// SPDX-License-Identifier: MIT
// A program of OpenGL ES 3.0 from a vertex and a fragment shader, for what the programs draw themselves.
#pragma once

#include <GLES3/gl3.h>

namespace karst::app {

// gl: functions without their "gl". The program is the caller's to delete, whatever comes of it. False: the
// driver rejects it.
template <class Functions>
bool link_program(const Functions& gl, const char* vertex_text, const char* fragment_text, GLuint& program) {
  program = gl.CreateProgram();
  for (const bool vertex : {true, false}) {
    const GLuint shader = gl.CreateShader(vertex ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
    const char* const text = vertex ? vertex_text : fragment_text;
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  GLint linked = GL_FALSE;
  gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
  return linked != GL_FALSE;
}

}  // namespace karst::app
