// SPDX-License-Identifier: MIT
// A host that leaves karst an OpenGL context in the worst state there is: nothing at its initial value,
// objects of its own bound to everything. It can tell afterwards whether they are as they were, and whether
// state is as karst promises.
#pragma once

#include <GLES3/gl3.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "karst/types.h"
#include "platform/display.h"

namespace karst::test {

enum class Api { es, desktop };

// A context of its own.
class HostContext {
 public:
  explicit HostContext(Api api);

  bool ok() const { return display_ != nullptr; }
  Api api() const { return api_; }
  GlLoader loader();
  bool has(const char* extension) const { return extensions_.contains(extension); }
  int version() const { return version_; }  // 10 times

  // A function of any type.
  template <class Function>
  Function* get(const char* name) const {
    return reinterpret_cast<Function*>(display_->gl_function(name));
  }
  int integer(GLenum name) const;

 private:
  Api api_;
  std::unique_ptr<Display> display_;
  std::set<std::string, std::less<>> extensions_;
  int version_ = 0;
};

// A framebuffer with colour, depth and stencil, of one sample or four, on a background of its own.
class HostTarget {
 public:
  static constexpr int kWidth = 96;
  static constexpr int kHeight = 64;

  HostTarget(const HostContext& host, int samples);
  // Cleared as a host does it, whatever the state: colour, depth as given.
  void clear(float depth) const;
  // rgba, from the bottom.
  std::vector<std::uint8_t> picture() const;
  GLuint name() const { return framebuffer_; }

 private:
  const HostContext& host_;
  GLuint framebuffer_ = 0;
  GLuint resolved_ = 0;  // framebuffer of one sample
};

class DirtyHost {
 public:
  explicit DirtyHost(const HostContext& host);

  // Sets all state, binds all objects; framebuffer: bound for drawing. error: one is left pending.
  void dirty(GLuint framebuffer, bool error) const;
  // Whether foreign objects hold what they held; else what does not.
  std::string changed_objects() const;
  // Whether the error that dirty() left, and no other, is pending.
  std::string wrong_error(bool error) const;
  // State that is not as draw() promises; first_unit, first_block: karst's.
  std::string wrong_state(std::uint32_t first_unit, std::uint32_t first_block) const;
  // The same for uploads of texels.
  std::string wrong_upload_state(std::uint32_t first_unit) const;

 private:
  struct Texture {
    GLenum target;
    GLenum binding;
    GLuint name;
  };

  void clean_up();
  void make_textures();
  void make_buffers();
  void make_vertex_array();
  void make_framebuffers();
  void make_program();
  void make_rest();
  void set_switches() const;
  void set_values() const;
  void set_desktop() const;
  void set_extensions() const;
  void set_pixels() const;
  void bind_units() const;
  void bind_buffers() const;
  std::vector<std::uint8_t> read_texture(const Texture& texture) const;
  std::vector<std::uint8_t> read_buffer(GLuint name) const;
  std::vector<std::uint8_t> contents() const;
  void check(std::string& wrong, const char* text, GLenum name, std::vector<int> expected) const;
  void check_switch(std::string& wrong, const char* text, GLenum name, bool expected) const;
  void check_unpacking(std::string& wrong) const;
  void check_extensions(std::string& wrong) const;

  const HostContext& host_;
  std::vector<Texture> textures_;
  std::vector<GLuint> buffers_;
  GLuint array_ = 0;
  GLuint framebuffer_ = 0, read_framebuffer_ = 0, renderbuffer_ = 0, scratch_ = 0;
  GLuint program_ = 0, sampler_ = 0, feedback_ = 0, query_ = 0;
  std::vector<std::uint8_t> contents_;
};

}  // namespace karst::test
