// SPDX-License-Identifier: MIT
// The OpenGL ES 3.0 pipeline: all GL objects are made by create() and none after it; a frame allocates
// nothing.
//
// Vertices of all patches lie in one buffer, cut into pages (terrain/resident/page_table.h); a small texture
// tells the vertex shader by page which patch it is of, another by patch where its vertices morph
// (terrain/lod/morph.h). Indices are streamed as 32 bits from the shared tables
// (terrain/draw/expand_indices.h), so a pass is one draw call, or a few where the stream is full.
//
// At most kFramesInFlight frames are under way: before anything of frame n is uploaded or drawn, frame n -
// kFramesInFlight is complete. So pages that the last kFramesInFlight frames did not draw may be written
// again, and writing waits for nothing else.
//
// Needs a current context in every call, the destructor included.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "karst/status.h"
#include "renderer/gl/gl.h"
#include "renderer/gl/gl_caps.h"
#include "renderer/gl/gpu_timer.h"
#include "renderer/passes/frame_block.h"
#include "renderer/passes/programs.h"
#include "terrain/base/budget.h"
#include "terrain/draw/draw_list.h"
#include "terrain/draw/expand_indices.h"
#include "terrain/field/octree.h"
#include "terrain/lod/morph.h"
#include "terrain/patch/gpu_vertex.h"
#include "terrain/resident/page_table.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/shading.h"
#include "terrain/shadow/cascades.h"
#include "terrain/view/camera.h"

namespace karst::core {

// What a picture shows.
enum class Show : std::uint8_t {
  materials,
  cascades,  // the shadow map that each pixel is looked up in
  levels     // triangles, by their level of detail
};

struct RendererSettings {
  int width = 1280;  // of the picture, pixels, 1..kMaxPicture
  int height = 720;
  std::uint32_t vertex_pages = 0;    // Config::gpu_vertex_pages, 1..kMostPages
  std::uint32_t morph_rows = 0;      // most patches that are resident at a time, 1..kMostPages
  std::uint32_t stream_indices = 0;  // Config::stream_indices, at least max_patch_indices(max level drawn)
  glm::ivec3 extent{1};              // of the world, voxels, 1..2^kMaxDepth on each axis
  bool rgb565 = false;               // 16 bits a pixel instead of 32: for screens that show no more
  // An image that is laid over the world from above instead of its materials; 0: none. Pixels, both 0 or
  // both 1..kMaxPicture.
  int drape_width = 0;
  int drape_height = 0;
  double drape_repeat = 1;  // times that it covers the world's content on each axis, 2^-10..2^10
  // Of the materials' textures, terrain/shading/materials.h; count 0: one plain material.
  std::uint32_t material_count = 0;  // 0..kMostMaterials
  std::uint32_t material_side = 0;   // texels, a power of two within 16..1024
  TextureFormat material_format = TextureFormat::rgba8;
  bool high_precision = false;  // all of a pixel is computed in 32 bits, for comparison
  Show show = Show::materials;  // with a drape always what that shows
  int cascades = 0;             // shadow maps, 0..kMostCascades; with a drape there are none
  int shadow_size = 1024;       // texels a side, as in CascadeSettings
  int shadow_bits = 16;         // of depth, 16 or 24 (which takes 32)
  bool keep_depth = false;      // keeps the depth of a frame for read_depth(); costs bandwidth on tiling GPUs

  bool debug = false;  // takes the driver's error messages (message()); wants a debug context

  static constexpr int kMaxPicture = 16384;  // pixels a side

  // invalid_argument naming the first field outside its range.
  Status validate() const;
  // Adds what create() will take.
  void add_to(Budget& budget) const;
};

// What pixels skip that changes no bit of them; false: all pixels do it.
struct PixelSkips {
  bool triplanar = true;  // planes of weight zero
  bool blend = true;      // the second material where the first covers all
  bool detail = true;     // the near scale where it has faded
  bool sun = true;        // shadows and mirrored light where no sun falls
};

struct FrameInput {
  Camera camera;
  FrameLight light;
  float least_cos2 = 1.0f;                      // ErrorScale's, which the morph rows were made for
  std::span<const DrawItem> items;              // of a valid draw list; may be empty
  unsigned shading = kShadeBlend | kShadeCave;  // what any of the items needs, PatchShading::needs
  PixelSkips skips;
  std::span<const PointLight> lights;          // at most kMostLights
  PageTable pages;                             // the one that uploads were made with
  std::span<const std::uint16_t> index_table;  // build_index_tables()
  int max_level = kMaxLevel;                   // of index_table and items
  // Shadow maps that the sun's light is looked up in, smallest first, at most settings().cascades; their
  // contents are those of the last draw_cascade(). None: the sun reaches everything.
  LightSpace light_space;
  std::span<const Cascade> cascades;
  // Counter-clockwise turns by 90 degrees, for screens that stand on their side: the picture lies turned in
  // the target, and the camera's aspect is that of the upright picture.
  int quarter_turns = 0;
};

// What is drawn into a shadow map. items, pages, index_table, max_level: as in FrameInput.
struct CascadeInput {
  Cascade cascade;
  std::span<const DrawItem> items;
  PageTable pages;
  std::span<const std::uint16_t> index_table;
  int max_level = kMaxLevel;
};

struct FrameCounts {
  std::uint64_t triangles = 0;  // submitted, all passes
  std::uint32_t draw_calls = 0;
  std::uint32_t left_out = 0;        // items without resident vertices; see ExpandIndices
  std::uint64_t uploaded_bytes = 0;  // vertices and texels since the last frame
  // The driver lost the vertex buffer, which it may do where the screen's mode changes: all vertices have to
  // be uploaded again; nothing is drawn until then.
  bool vertices_lost = false;
};

class Renderer {
 public:
  static constexpr std::uint32_t kFramesInFlight = 2;  // one that the GPU draws, one that the CPU prepares

  Renderer() = default;
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;
  ~Renderer() { destroy(); }

  // unsupported or limit_reached where the device cannot do it, naming the function, limit or shader;
  // message() then may hold more. The renderer is empty after a failure.
  Status create(const Gl& gl, const RendererSettings& settings);
  void destroy();

  // What the driver said when create() failed, or the first KHR_debug error since; "" where nothing was said.
  const char* message() const { return message_; }
  const GlCaps& caps() const { return caps_; }
  const RendererSettings& settings() const { return settings_; }

  // The image of settings().drape_width x drape_height: rgba of 8 bits, row 0 in the north (-z), alpha
  // unused. invalid_argument where it is too short or the settings have none.
  Status upload_drape(std::span<const std::uint8_t> rgba);

  // What lies where; its count, side and format are the settings'. invalid_argument where they are not.
  Status set_materials(const MaterialSet& materials);
  // Layers from `first_layer` on of a level of an array, as they lie in the world file. To be called for all
  // of them. invalid_argument naming what does not fit.
  Status upload_textures(TextureArray array, int level, int first_layer, int layers,
                         std::span<const std::byte> bytes);

  // Tells where the ground is open to the sky (sky_line.h). Without it, all of it is.
  void upload_sky_line(const Octree& octree);

  // Copies vertices of a patch's slot, from vertex `first` on, to the pages of its chain, which must reach
  // that far; writes these pages' texels. Pages must be new, or not drawn in the last kFramesInFlight frames;
  // vertices of a page that are not written stay. origin: the patch's, in voxels. row: its morph row.
  // invalid_argument naming patch, vertices, origin or row; limit_reached where the driver cannot map its
  // buffer. Nothing was written then.
  Status upload_vertices(const PageTable& pages, PatchId patch, std::uint32_t first,
                         std::span<const GpuVertex> vertices, glm::ivec3 origin, std::uint32_t row,
                         PatchShading shading = {});
  // Rows of thresholds, kMorphRow values each as make_morph_row() fills them. A patch's row must be there
  // before it is drawn. invalid_argument where they are not whole or not within the settings' morph_rows.
  Status upload_morph_rows(std::uint32_t first_row, std::span<const std::uint16_t> rows);

  // Draws a shadow map, which keeps until it is drawn again; its calls are counted by the next draw().
  // invalid_argument names what does not fit.
  Status draw_cascade(int index, const CascadeInput& input);

  // Draws one picture into the offscreen target. invalid_argument names what does not fit; nothing is drawn
  // then.
  Status draw(const FrameInput& input, FrameCounts& counts);
  void finish() { gl_.Finish(); }
  // Copies the last picture to framebuffer 0, which is the display's and of the picture's size or larger.
  void present();

  // GPU time of the newest finished frame's terrain pass in milliseconds; NaN where it is not known (yet).
  double terrain_gpu_ms() { return timer_.latest_ms(gl_); }
  // The same of the newest shadow map that was drawn.
  double shadow_gpu_ms() { return shadow_timer_.latest_ms(gl_); }

  // Reads the last picture, row 0 at the top. rgba: width x height x 4 bytes.
  Status read_colour(std::span<std::uint8_t> rgba);
  // Reads its depth, row 0 at the top, 0 (near) to 1 (far), steps of 1/(2^24 - 1). depth: width x height.
  // Needs keep_depth; overwrites the picture, so read_colour() comes first.
  Status read_depth(std::span<float> depth);

  // The first GL error since the last call, GL_NO_ERROR where there was none. For tests and for the end of a
  // run: asking makes some drivers wait.
  GLenum take_error();

 private:
  static constexpr std::uint32_t kMostPageRows = kMostPages >> KARST_PAGE_ROW_BITS;

  Status check_device() const;
  Status create_targets();
  void create_buffers();
  void create_textures();
  void label_objects();
  GLuint make_texture(GLenum unit, GLenum format, int levels, int width, int height, GLenum filter);
  Status check_upload(const PageTable& pages, PatchId patch, std::uint32_t first, std::size_t vertices,
                      glm::ivec3 origin, std::uint32_t row) const;
  bool map_vertices();
  void flush_uploads(const PageTable& pages);
  void upload_page_rows(const PageTable& pages);
  void wait_for_frame();
  Status create_shadow_maps();
  void begin_frame(const PageTable& pages);
  void use_block(GLuint buffer, const shader::FrameBlock& block);
  void draw_sky(FrameCounts& counts);
  void create_materials();
  Status draw_shown(const FrameInput& input, const ExpandIndices& expand, FrameCounts& counts);
  Status draw_items(ExpandIndices expand, int max_level, FrameCounts& counts);
  void read_pixels(void* rgba);
  void push_group(const char* name);
  void pop_group();
  static void GL_APIENTRY on_debug_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                           GLsizei length, const GLchar* text, const void* user);

  Gl gl_;
  GlCaps caps_;
  RendererSettings settings_;
  bool created_ = false;
  bool has_picture_ = false;
  Programs programs_;
  GpuTimer timer_;
  GpuTimer shadow_timer_;
  GLuint vertex_buffer_ = 0;
  GLuint index_buffer_ = 0;
  GLuint frame_buffer_ = 0;                     // the uniform block's
  GLuint cascade_buffers_[kMostCascades] = {};  // the block's, of passes into shadow maps
  GLuint vertex_array_ = 0;
  GLuint no_attributes_ = 0;  // vertex array of the full-screen passes
  GLuint page_table_ = 0;
  GLuint morph_entries_ = 0;
  GLuint morph_rows_ = 0;
  GLuint material_arrays_[kTextureArrays] = {};
  GLuint variation_ = 0;
  GLuint material_buffer_ = 0;  // the uniform block's
  GLuint sky_line_ = 0;
  GLuint drape_ = 0;                           // 0: none
  GLuint shadow_maps_ = 0;                     // texture array, a layer a cascade
  GLuint shadow_targets_[kMostCascades] = {};  // framebuffers, one a layer
  GLuint depth_ = 0;
  GLuint colour_ = 0;
  GLuint target_ = 0;                             // framebuffer: colour_ and depth_
  GLuint colour_target_ = 0;                      // framebuffer: colour_ alone
  std::bitset<kMostPageRows> changed_page_rows_;  // rows of texels that the texture does not have yet
  GpuVertex* mapped_ = nullptr;                   // the whole vertex buffer, between an upload and a frame
  FrameCounts pending_;                           // of what was done for the next frame already
  std::uint64_t frame_ = 0;
  GLsync fences_[kFramesInFlight] = {};  // of the last frames, by frame
  char message_[2048] = {};
};

}  // namespace karst::core
