// SPDX-License-Identifier: MIT
// The OpenGL ES 3.0 pipeline, as a guest in a host's context and framebuffer: all GL objects are made by
// create() and none after it; a frame allocates nothing.
//
//   renderer.create(gl, settings);
//   each frame: renderer.upload_vertices(...), renderer.upload_morph_rows(...)
//               renderer.draw_cascade(...)                  shadow maps that changed
//               bind a framebuffer with depth, clear it;  renderer.draw(view, {.viewport = {0, 0, w, h}});
//               renderer.end_frame();
//
// Vertices of all patches lie in one buffer, cut into pages (terrain/resident/page_table.h); a small texture
// tells the vertex shader by page which patch it is of, another by patch where its vertices morph
// (terrain/lod/morph.h). Indices are streamed as 32 bits from the shared tables
// (terrain/draw/expand_indices.h), anew in each draw(), so a pass is one draw call, or a few where the stream
// is full.
//
// At most kFramesInFlight frames are under way: before anything of frame n is uploaded or drawn, frame n -
// kFramesInFlight is complete. So pages that the last kFramesInFlight frames did not draw may be written
// again, and writing waits for nothing else.
//
// State. Only create() asks GL for anything; it also takes errors that are pending (pending_error()). No
// other call asks for state, errors or, unless it says so, results. All state that a call depends on is set
// by it. Not to be active during a call: queries, transform feedback, conditional rendering. create(),
// draw_cascade(), draw() and reset_state() leave this behind:
//   bindings    program, vertex array, array, uniform and pixel unpack buffer 0; active texture unit 0; on
//               the settings' texture units the targets that karst uses on them, and samplers, unbound; the
//               settings' uniform blocks unbound
//   initial     pixel store parameters of unpacking; scissor, depth and stencil test, blending, culling,
//               polygon offset, rasterizer discard, sample coverage, alpha to coverage, primitive restart,
//               dithering; depth function, mask and range; colour mask; cull face and front face; where the
//               context has them: sample mask and shading, clip distances, clip control, depth clamp, polygon
//               mode, logic operation, multisampling, framebuffer sRGB, provoking vertex
//   viewport    the target's or the shadow map's, after drawing
//   framebuffer draw() leaves what is bound, or with a G-buffer the target's for drawing; create() and
//               draw_cascade() unbind it
// An upload touches some of the unpacking, the active unit, the array and the uniform buffer, and the
// textures of the first unit (2D, 3D and 2D arrays); what it touches it leaves so. All else stays as it is:
// blend and stencil functions and values of polygon offset too.
//
// Needs the context that was current in create() in every call, the destructor included; after forget() none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "karst/status.h"
#include "renderer/gl/frame_fences.h"
#include "renderer/gl/gl_device.h"
#include "renderer/gl/gpu_timer.h"
#include "renderer/input/settings.h"
#include "renderer/input/view_input.h"
#include "renderer/passes/programs.h"
#include "renderer/resources/vertex_pages.h"
#include "terrain/field/octree.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/shading/painted_texels.h"

namespace karst::core {

class Renderer {
 public:
  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer() { destroy(); }

  // unsupported or limit_reached where the device cannot do it, naming the function, limit or shader;
  // message() then may hold more. The renderer is empty after a failure.
  Status create(const Gl& gl, const RendererSettings& settings);
  void destroy();
  // Instead of destroy() where the context is lost or gone: forgets all objects without calling GL.
  void forget();

  // What the driver said when create() failed, or the first KHR_debug error since; "" where nothing was said.
  const char* message() const { return message_; }
  // The host's error that create() found, GL_NO_ERROR where there was none.
  GLenum pending_error() const { return pending_error_; }
  const GlCaps& caps() const { return device_.caps; }
  const RendererSettings& settings() const { return settings_; }
  // The texture that has the targets' depth, or 0: settings().share_depth, and there is a G-buffer.
  GLuint shared_depth() const;
  // Bytes of buffers and textures that are there.
  std::size_t gpu_bytes() const { return device_.objects.total_bytes(); }

  // The image of settings().drape_width x drape_height: rgba of 8 bits, row 0 in the north (-z), alpha
  // unused. invalid_argument where it is too short or the settings have none.
  Status upload_drape(std::span<const std::uint8_t> rgba);

  // What lies where; its count, side and format are the settings'. invalid_argument where they are not.
  Status set_materials(const MaterialSet& materials);
  // Layers from `first_layer` on of a level of an array, as they lie in the world file. To be called for all
  // of them. invalid_argument naming what does not fit.
  Status upload_textures(TextureArray array, int level, int first_layer, int layers,
                         std::span<const std::byte> bytes);

  // Texels of an image tile, both levels, to a layer; and a part of a view's table of tiles
  // (terrain/imagery/image_view.h). invalid_argument naming what does not fit.
  Status upload_image(std::uint32_t layer, std::span<const std::byte> texels);
  Status upload_image_table(std::uint32_t view, int size, std::span<const std::uint16_t> part);

  // Texels of the blend map, row by row, and, after the last of them, its coarser levels. invalid_argument
  // ("texels", also where there is no map; "bytes").
  Status upload_blend_texels(const TexelRect& texels, std::span<const std::byte> bytes);
  void finish_blend_map();
  // Where the ground ends (surroundings.h); without it there is no wall. plain_steps: height of the plain.
  // invalid_argument where the settings have no room for it.
  Status upload_rim(std::span<const glm::ivec3> rim, std::int32_t plain_steps);

  // Where octrees lie, another than the settings say: within the same cells. Precondition: of as many.
  void set_sky(const SkyAtlas& sky);
  // How much of the sky is seen from where; its grid is the settings'. Without it, all of it is everywhere.
  // invalid_argument where the grid is another one.
  Status upload_sky(const SkyVisibility& sky, std::size_t place = 0);

  // Copies vertices of a patch's slot, from vertex `first` on, to the pages of its chain, which must reach
  // that far; writes these pages' texels. Pages must be new, or not drawn in the last kFramesInFlight frames;
  // vertices of a page that are not written stay. origin: the patch's, in voxels. row: its morph row.
  // invalid_argument naming patch, vertices, origin or row; limit_reached where the driver cannot map its
  // buffer. Nothing was written then.
  Status upload_vertices(const PageTable& pages, PatchId patch, std::uint32_t first,
                         std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                         PatchShading shading = {});
  // Writes the texels of the pages that hold so many vertices of a patch, which stay as they are. Errors as
  // above.
  Status upload_shading(const PageTable& pages, PatchId patch, std::uint32_t vertices, glm::ivec3 origin,
                        std::uint32_t row, PatchShading shading);
  // Copies a node's vertices to a page, counted among those of families, and writes its texel, which goes to
  // pages.family_texels; the same rules of what may be written and drawn. invalid_argument naming page,
  // origin, size, quadrant, row or material; limit_reached as above. Nothing was written then.
  Status upload_node(const PageTable& pages, std::uint32_t page, const NodePage& node,
                     std::span<const GpuVertex, kNodePageVertices> vertices);
  // Copies a mesh's vertices to the pages of its chain, counted among the settings' mesh_pages, and writes
  // their texels, which go to pages.mesh_texels; the same rules. invalid_argument naming page, origin or
  // size; limit_reached as above.
  Status upload_mesh(const PageTable& pages, const MeshPages& chain, const MeshPage& mesh,
                     std::span<const GpuVertex> vertices);
  // Rows of thresholds, kMorphRow values each as make_morph_row() fills them; those of families follow the
  // settings' morph_rows. A patch's or family's row must be there before it is drawn. invalid_argument where
  // they are not whole or not within the settings' morph_rows and family_rows.
  Status upload_morph_rows(std::uint32_t first_row, std::span<const std::uint16_t> rows);

  // What air.glsl's block holds in a view, make_air_block(). invalid_argument where the settings have fewer.
  Status set_air(std::uint32_t view, const shader::KarstAir& block);
  // The uniform buffer of a view's air, and the array of shadow maps, which compares; 0 where there is none.
  GLuint air_block(std::uint32_t view) const;
  GLuint shadow_maps() const;

  // Draws a shadow map, which keeps until it is drawn again. invalid_argument names what does not fit.
  Status draw_cascade(int index, const CascadeInput& input);

  // Draws a view into the framebuffer that is bound for drawing, which has depth, cleared to that of the far
  // plane where nothing is drawn yet. Neither clears nor invalidates it. Writes its colour to location 0.
  // invalid_argument names what does not fit; nothing is drawn then.
  Status draw(const ViewInput& input, const DrawTarget& target);
  // Ends the frame; what is uploaded later is for the next one.
  FrameCounts end_frame();

  // Leaves state as draw() does, for a host's call in which nothing is drawn. unbind: the framebuffer too.
  void reset_state(bool unbind) const;

  void finish() { device_.gl.Finish(); }

  // GPU time of the newest finished draw() in milliseconds; NaN where it is not known (yet), or without
  // settings().timers. Asks the driver for results.
  double terrain_gpu_ms() { return timer_.latest_ms(device_.gl); }
  // The same of the newest shadow map that was drawn.
  double shadow_gpu_ms() { return shadow_timer_.latest_ms(device_.gl); }

 private:
  Status check_device() const;
  Status create_objects();
  void listen(bool on);
  void begin(const PageTable& pages);
  bool is_deferred(const ViewInput& input, const DrawTarget& target) const;
  template <class Draw>
  Status in_ranges(const ViewInput& input, const DrawTarget& target, Draw&& draw);
  Status draw_forward(const ViewInput& input, const DrawTarget& target);
  Status draw_deferred(const ViewInput& input, const DrawTarget& target);
  static void GL_APIENTRY on_debug_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                           GLsizei length, const GLchar* text, const void* user);

  GlDevice device_;
  RendererSettings settings_;
  bool created_ = false;
  GLenum pending_error_ = GL_NO_ERROR;
  Programs programs_;
  GpuTimer timer_;
  GpuTimer shadow_timer_;
  VertexPages pages_;
  std::uint32_t rim_vertices_ = 0;
  FrameFences fences_;
  FrameCounts counts_;  // of the frame so far
  char message_[2048] = {};
};

}  // namespace karst::core
