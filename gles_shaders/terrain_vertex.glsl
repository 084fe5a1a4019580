// SPDX-License-Identifier: MIT
// What all passes over the terrain do with a vertex's 16 bytes: find its patch and its threshold by the page
// it lies in, and move it to where the frame's camera wants it. All passes of a frame thereby draw the same
// surface.
//
// Positions stay exact (design 4.3): a place is the same real number correctly rounded in every patch or
// node that has it, of whichever size (place.glsl). So are the way to the morph target and the share of it
// in all that are of one size, and with `invariant` gl_Position: no crack can open.
#include "octahedral.glsl"
#include "morph.glsl"
#include "place.glsl"
#include "level.glsl"
#ifdef KARST_VOXEL_MATERIALS
#define KARST_VOXEL_VERTEX
#include "voxel_materials.glsl"
#endif

layout(location = KARST_LOCATION_POSITION) in ivec4 position_normal;
layout(location = KARST_LOCATION_MORPH) in ivec4 morph_normal;

uniform highp usampler2D page_table;  // a texel a page: terrain/resident/page_table.h
uniform highp usampler2D morph_entries;  // r: entry in a row, by vertex of a slot
uniform highp sampler2D morph_rows;  // r: threshold in units of KARST_THRESHOLD_UNIT

invariant gl_Position;

struct TerrainVertex {
  ivec3 patch_voxel;  // the page's origin, voxels from the octree's minimum corner, modulo 2^32
  vec3 in_patch;      // lattice steps from there
  vec3 position;      // lattice steps from camera_voxel
  vec3 home;          // where it is when it does not move
  float share;        // of the way to its morph target, 0..1
  int material;       // of all of its patch, or less than 0
  int cave;           // 1 where its patch may be a cave or lit by lamps, or 0
  int node_size;      // of a node or a mesh, or less than 0 of a patch
  int voxels;         // of a mesh: its materials (voxel_materials.glsl), else 0
#if defined(KARST_CURVED) && defined(KARST_IMAGERY)
  vec2 image_place;  // tiles of size 0 from the corner of the one that windows lie around
#endif
};

#if defined(KARST_CURVED) && defined(KARST_IMAGERY)
// By vertex of a node's page: the sample's column, and 8 times its row (vertex_order() of
// terrain/patch/gpu_vertex.h, then the corners of make_node.h).
const int kNodeSamples[29] = int[29](0, 16, 32, 2, 18, 34, 4, 20, 36, 8, 24, 1, 9, 17, 25, 33, 10, 26, 3, 11,
                                     19, 27, 35, 12, 28, 0, 32, 36, 4);

// Where a vertex lies among images: as its sample does, at home or not, since a target is the middle of two
// samples as far to either side. Below a corner of a node that corner counts.
vec2 image_place_of(int page, int in_page) {
  int place = page + (image_sizes.w << KARST_PAGE_ROW_BITS);
  uvec4 node = texelFetch(page_table, ivec2(place & KARST_MASK(KARST_PAGE_ROW_BITS),
                                            place >> KARST_PAGE_ROW_BITS), 0);
  int size = int(node.z);
  ivec2 from_centre = (ivec2(node.xy) << size) - image_centre.xy;
  int at = kNodeSamples[min(in_page, 28)];
  return vec2(from_centre) + vec2(at & 7, at >> 3) * (0.25 * power_of_two(size));
}
#endif

TerrainVertex read_terrain_vertex() {
  int page = gl_VertexID >> KARST_PAGE_BITS;
  uvec4 texel = texelFetch(page_table, ivec2(page & KARST_MASK(KARST_PAGE_ROW_BITS),
                                             page >> KARST_PAGE_ROW_BITS), 0);
  int place = int(texel.w) & KARST_MASK(KARST_PLACE_BITS);
  int vertex = place << KARST_PAGE_BITS | (gl_VertexID & KARST_MASK(KARST_PAGE_BITS));
  int entry = int(texelFetch(morph_entries, ivec2(vertex & KARST_MASK(KARST_ENTRY_ROW_BITS),
                                                  vertex >> KARST_ENTRY_ROW_BITS), 0).x);
  int row = (place < KARST_FIRST_GROUND_PLACE ? first_rows.x : first_rows.y) +
            (int(texel.w >> KARST_PLACE_BITS) & KARST_MASK(KARST_ROW_BITS));
  ivec2 at = ivec2((row & KARST_MASK(KARST_MORPH_ROW_BITS)) * KARST_MORPH_ROW + entry,
                   row >> KARST_MORPH_ROW_BITS);
  float threshold = texelFetch(morph_rows, at, 0).x * KARST_THRESHOLD_UNIT;

  const int kAboveY = 32 - KARST_ORIGIN_Y_BITS;
  ivec3 origin = ivec3(int(texel.x), int(texel.z << kAboveY) >> kAboveY, int(texel.y));
  int size = int(texel.z >> KARST_ORIGIN_Y_BITS) & KARST_MASK(KARST_SIZE_BITS);
  PageReference reference = page_reference(camera_voxel.xyz, size, origin);
  vec3 home = place_in_page(reference, position_normal.xyz);
  vec3 target = place_in_page(reference, morph_normal.xyz);
  vec3 way = vec3(morph_normal.xyz - position_normal.xyz);  // steps of the size
  float apparent = apparent_distance(home - camera_fine.xyz, morph_view.xyz, morph_view.w);

  TerrainVertex result;
  result.share = morph_share(
      apparent, threshold,
      place < KARST_FIRST_GROUND_PLACE ? KARST_MORPH_SHARE : KARST_NODE_MORPH_SHARE);
  if (place == KARST_MESH_PLACE) result.share = 0.0;
  result.voxels = place == KARST_MESH_PLACE ? morph_normal.w & 0xffff : 0;
  result.patch_voxel = origin << size;
  result.in_patch = (vec3(position_normal.xyz) + way * result.share) * reference.unit;
  result.material = int(texel.w >> KARST_MATERIAL_SHIFT) - 1;
  result.cave = int(texel.z >> KARST_CAVE_SHIFT);
  result.node_size = place < KARST_MESH_PLACE ? -1 : size;
  result.home = home;
  result.position = morph_position(home, way * reference.unit, target, result.share);
  int in_page = gl_VertexID & KARST_MASK(KARST_PAGE_BITS);
#if defined(KARST_CURVED) && defined(KARST_IMAGERY)
  result.image_place = image_place_of(page, in_page);
#endif
  if (place >= KARST_FIRST_GROUND_PLACE && in_page >= KARST_NODE_VERTICES) {
    // Below a corner of a node, where its wall ends.
#ifdef KARST_CURVED
    vec3 from_eye = (result.position - camera_fine.xyz) / KARST_STEPS_PER_VOXEL;
    vec3 down = level_up(from_eye) * ((level_height(from_eye) - level_eye.z) * KARST_STEPS_PER_VOXEL);
    result.in_patch -= down;
    result.position -= down;
#else
    result.in_patch.y += camera_fine.w - result.position.y;
    result.position.y = camera_fine.w;
#endif
  }
  return result;
}

// Not of unit length while the vertex is on its way.
vec3 morphed_normal(float share) {
  return mix(octahedral_decode(position_normal.w), octahedral_decode(morph_normal.w), share);
}
