// SPDX-License-Identifier: MIT
// What C++ and GLSL must agree on: attribute locations, texture units, sizes, and the uniform block. This
// one file is included by the shaders (GL_ES is defined there) and by renderer/input/shader_interface.h;
// tests/gl checks that a linked program has exactly these locations and offsets. Blocks hold vec4, ivec4 and
// mat4 only, so that std140 and C++ lay them out alike.

// Attributes: the 16 bytes of a vertex (terrain/patch/gpu_vertex.h), as two ivec4 of four shorts.
#define KARST_LOCATION_POSITION 0 // xyz: position, w: packed normal
#define KARST_LOCATION_MORPH 1    // xyz: morph position, w: packed morph normal

// Texture units, from the first that a host gives.
#define KARST_UNIT_PAGE_TABLE 0
#define KARST_UNIT_MORPH_ENTRIES 1
#define KARST_UNIT_MORPH_ROWS 2
#define KARST_UNIT_FAR_TEXTURES 3
#define KARST_UNIT_SKY_VISIBILITY 4
#define KARST_UNIT_VARIATION 5
#define KARST_UNIT_DRAPE 6
#define KARST_UNIT_SHADOW_MAPS 7
#define KARST_UNIT_NEAR_TEXTURES 8
#define KARST_UNIT_GEOMETRY 9
#define KARST_UNIT_BLEND_MAP 10
#define KARST_UNIT_IMAGE_TILES 11
#define KARST_UNIT_IMAGE_TABLE 12
#define KARST_UNIT_GEOMETRY_VOXELS KARST_UNIT_DRAPE  // under a drape there is no G-buffer
#define KARST_UNITS 13

// Binding points of the uniform blocks, from the first that a host gives.
#define KARST_BINDING_FRAME 0
#define KARST_BINDING_MATERIALS 1
#define KARST_BLOCKS 2

#define KARST_MASK(bits) ((1 << (bits)) - 1)

// A page is 2^5 vertices. What textures hold by page, by vertex of a slot and by patch is laid out in rows
// of a power of two: page n has texel (n & 1023, n >> 10).
#define KARST_PAGE_BITS 5
#define KARST_PAGE_ROW_BITS 10
#define KARST_ENTRY_ROW_BITS 7
// Thresholds of a patch are 32 texels; 64 patches lie side by side, which makes a row of 2048 texels.
#define KARST_MORPH_ROW 32
#define KARST_MORPH_ROW_BITS 6

// A texel of the page table. x, y: the origin's x and z, voxels of the page's size. z: the origin's y, 26
// bits, the size, and one bit for caves. w: place of the page in its chain, 8 bits; the row of thresholds, 20
// bits; and 4 bits for the one material that all of it has, plus 1, or 0.
#define KARST_ORIGIN_Y_BITS 26
#define KARST_SIZE_BITS 5
#define KARST_CAVE_SHIFT 31
#define KARST_PLACE_BITS 8
#define KARST_ROW_BITS 20
#define KARST_MATERIAL_SHIFT 28
// Of worlds with imagery on a curved basis, in rows behind those of all pages: for each page of a node a
// texel more, x, y: the node's x and z, z: its size (terrain/ground/ground.h).
//
// The place of pages of meshes, whose vertices do not morph (kMeshPlace, terrain/resident/page_table.h).
#define KARST_MESH_PLACE 251
// Places from here on are those of nodes (terrain/nodes/family_row.h).
#define KARST_FIRST_GROUND_PLACE 252
// Vertices of a page of a node; those behind them lie below its corners, at the feet of walls.
#define KARST_NODE_VERTICES 25

// Bits of a texel of the G-buffer, geometry.glsl.
#define KARST_GEOMETRY_MATERIAL_SHIFT 26
#define KARST_GEOMETRY_CAVE_SHIFT 30

// KARST_SHOW_LOOKUPS: red of a lookup, and blue of terrain, of 255.
#define KARST_LOOKUP_RED 12
#define KARST_LOOKUP_BLUE 64.0

// Materials: layers of the texture arrays. The renderer defines KARST_MATERIALS, how many there are.
#define KARST_MOST_MATERIALS 8
#ifndef KARST_MATERIALS
#define KARST_MATERIALS KARST_MOST_MATERIALS
#endif
// Voxels that one repeat of the textures covers, and one of the variation, are powers of two, so that
// positions can be taken modulo the repeat in integers and stay precise however far from the origin.
#define KARST_VARIATION_REPEAT 32
// Scales of the textures, from MaterialSet::repeat_log2 on, each 16 times as wide as the one before. By its
// footprint, a pixel looks up two that follow each other: near textures at the one, far textures, which have
// half as many texels, at the other; between the two lie so many levels of detail, half a one of which makes
// up for far textures having no slopes that beat with the pixel grid.
#define KARST_SCALE_LOG2 4
#define KARST_FAR_LEVELS 5.5
// Level of detail of near textures from which on a scale is looked up, but for the first.
#define KARST_SCALE_BEGINS -0.25
// How much of the textures' detail is looked up (karst::Detail); the renderer defines it.
#define KARST_DETAIL_LOW 0     // far textures alone, at the near scale
#define KARST_DETAIL_MEDIUM 1  // of the near scale one level, the next finer or coarser
#define KARST_DETAIL_HIGH 2    // of both scales two levels, mixed
#ifndef KARST_DETAIL
#define KARST_DETAIL KARST_DETAIL_HIGH
#endif
// Colours change from one scale to the next within 1 / this levels of detail, before it and after it.
#if KARST_DETAIL == KARST_DETAIL_LOW
#define KARST_FADE 1.0
#else
#define KARST_FADE 2.0
#endif
// In how many places at most a device looks up the longer side of a pixel's footprint; the renderer defines
// it.
#ifndef KARST_ANISOTROPY
#define KARST_ANISOTROPY 1
#endif
// epsilon of K's equation 4.4: 0.15 to 0.25 are good.
#define KARST_TRIPLANAR_EPSILON 0.2
// Levels of detail that lookups are blurred by: slopes at one texel a pixel would beat with the pixel grid.
#define KARST_SOFTEN_LEVELS 0.8
// Height of bumps where they are too fine to be seen.
#define KARST_MEAN_HEIGHT 0.5
// Sky visibility (terrain/field/sky_visibility.h) at which a cave begins, and at which it is dark.
#define KARST_CAVE_BEGINS 0.1
#define KARST_CAVE_IS_DARK 0.02
// Voxels from the eye at which the visitor's lamp fades out.
#define KARST_LAMP_REACH 28.0
#define KARST_MOST_LIGHTS 16
// Waves of the water.
#define KARST_WAVES 6
// Octrees that a world may have (terrain/base/config.h).
#define KARST_REGIONS 16
// Products of the normal with the sun's direction between which its light fades in.
#define KARST_SUN_GRAZES -0.05
#define KARST_SUN_SHINES 0.15

// Image tiles, terrain/imagery: texels a side without and of their border; tiles a side of a window of the
// table, and bits of an entry that hold the layer.
#define KARST_IMAGE_INSIDE 240.0
#define KARST_IMAGE_BORDER 8.0
#define KARST_IMAGE_WINDOW 32
#define KARST_IMAGE_LAYER_BITS 10
// Levels of detail that a texel is coarser than a pixel, from which on materials add all of their detail.
#define KARST_IMAGE_FADE 2.0

// Texels at the sides of a shadow map in which nothing is looked up.
#define KARST_SHADOW_BORDER 4.0

#define KARST_STEPS_PER_VOXEL 8192.0
#define KARST_STEPS_LOG2 13
// terrain/lod/morph.h: in lattice steps; the share of a threshold over which a vertex moves.
#define KARST_THRESHOLD_UNIT 524288.0
#define KARST_MORPH_SHARE 0.3
#define KARST_NODE_MORPH_SHARE 0.1  // terrain/ground/demand.h

#ifdef GL_ES
#define KARST_BLOCK(name) layout(std140) uniform name
// Of what 16 bits a number are enough for: colours, light, weights. KARST_HIGH_PRECISION is for comparison.
#ifdef KARST_HIGH_PRECISION
#define KARST_MEDIUM highp
#else
#define KARST_MEDIUM mediump
#endif
#else
#define KARST_BLOCK(name) struct alignas(16) name
#endif

// Everything that changes from frame to frame. Directions have unit length; colours are linear light.
// Components that are not named are 0.
KARST_BLOCK(FrameBlock) {
  mat4 clip_from_lattice;  // from lattice steps relative to camera_voxel
  ivec4 camera_voxel;      // xyz: whole voxels from the octree's minimum corner
  // xyz: the eye relative to camera_voxel, lattice steps; w: the height at which the ground's walls end
  vec4 camera_fine;
  ivec4 first_rows;        // row of morph_rows that the view's thresholds begin at, x: of patches, y: of
                           // families of nodes
  vec4 morph_view;         // xyz: direction of view; w: least cos^2, or less than 0; see apparent_distance in
                           // morph.glsl
  vec4 ray_right;          // xyz: the view ray of a pixel is ray_forward + ndc.x * ray_right + ndc.y * ray_up
  vec4 ray_up;
  vec4 ray_forward;
  // xyz: towards the sun, or by night the moon; w: how much stronger the sky's light is from there
  vec4 sun_direction;
  vec4 sun_light;          // rgb: light on a surface that faces it
  vec4 sky_light;          // rgb: light on a surface that faces the zenith
  vec4 ground_light;       // rgb: light on a surface that faces down
  vec4 sky_zenith;         // rgb: the sky itself; w: of stars
  vec4 sky_horizon;        // rgb: the sky at the horizon, and haze
  // x: 1 / distance at which 63 % is haze, 1/voxels; y: a pixel's size at distance 1, or in a parallel
  // view; z: 1 in parallel views, whose rays are all ray_forward, or 0; w: 1 where the target takes light
  // instead of what a display shows, or 0
  vec4 view_scale;
  vec4 sky_scale;          // of sky_visibility: xyz: 1 / size in x, z and y, 1/voxels; w: a cell, voxels
  // Of several octrees (terrain/field/sky_atlas.h), x of them. xyz: low corner, voxels; w: a cell, voxels
  ivec4 sky_octrees;
  vec4 sky_corner[KARST_REGIONS];
  // xy: voxels along x and z; z: first layer of cells; w: layers of cells
  vec4 sky_box[KARST_REGIONS];
  // Shadow maps, terrain/shadow/cascades.h. from_eye: a point less the eye, voxels.
  // xyz: light space's x is its dot product with from_eye; w: how far what casts may stray, a voxel from the
  // eye
  vec4 shadow_x;
  vec4 shadow_y;           // the same for y
  vec4 shadow_z;           // depth in a map is the dot product of xyz with from_eye, plus w
  vec4 shadow_box_0;       // of a map: place in it is light space's xy * z + xy; w: a texel, voxels
  vec4 shadow_box_1;
  vec4 shadow_box_2;
  vec4 shadow_scale;       // x: number of maps, y: texels a side, z: 1 / y, w: depth a voxel
  vec4 drape_place;        // place in the image over a column: xz * xy + zw, x and z in voxels
  // Surroundings, terrain/shading/surroundings.h. Heights are voxels above the eye.
  // x: of the water's level, far below where there is none; y: metres a voxel. Of a curved basis: z: of its
  // level above height 0; w: |q|^2 of the eye less that at its level
  vec4 water;
  // xy: wave vector on x and z, radians a voxel, w: its length; z: phase at the eye. Of a curved basis xyz:
  // wave vector; w: phase
  vec4 water_wave[KARST_WAVES];
  vec4 plain;              // rgb: albedo, w: height, far above where there is none
  // Of a curved basis, terrain/basis/level_view.h: rows of the scale, w: of the eye.
  vec4 level_x;
  vec4 level_y;
  vec4 level_z;
  vec4 level_eye;  // x: |q|^2 - 1 of the eye; y: sign; z: height at which walls end; w: of the eye
  vec4 level_top;  // xyz: up at the eye; w: the sine by which the horizon is lower than level
  // x: the sky's brightness at the eye; y: 1 / height in which air thins by e, 1/voxels, or 0
  // z: |q|^2 - 1 of the plain beyond the ground; w: 1 where there is one, or 0
  vec4 level_air;
  // What every pixel does whether it needs it or not, to measure what skipping saves; 1 or 0. x: the second
  // plane, y: the second material, z: the near scale, w: looking at the sun.
  ivec4 least_work;
  // The screen pass. xy: the viewport's corner, pixels; z: bit 0, the sky is drawn; bit 1, depth is in two
  // ranges (screen_pass.cpp); w: width, and height * 2^16
  ivec4 screen_place;
  // x: depth along the ray, voxels, a clip w; y: the far plane's depth; depth is ndc z * z + w
  vec4 screen_scale;
  vec4 screen_depth;  // clip z is the dot product of xyz with from_eye, plus w
  // Imagery, ImagePlace of terrain/imagery/image_view.h.
  ivec4 image_centre;  // xy: the tile of size 0 that windows lie around
  // x: the least, y: the greatest; z: the view's place in the table; w: on a curved basis the row of the page
  // table at which texels of nodes' places begin
  ivec4 image_sizes;
  vec4 image_eye;      // xy: the eye from the centre's corner, tiles of size 0
  vec4 image_scale;    // of size 0: xy: tiles a voxel, z: texels a voxel
  // Point lights, terrain/shading/materials.h.
  vec4 light_scale;        // x: number of lights, y: 1 where caves keep the sun out without shadow maps
  vec4 light_place[KARST_MOST_LIGHTS];   // xyz: from the eye, w: reach; voxels
  vec4 light_colour[KARST_MOST_LIGHTS];  // rgb
};

// What stays the same for a world. Material, terrain/shading/materials.h, by layer.
KARST_BLOCK(MaterialBlock) {
  // x: 1 / texels of a near texture's side; log2 of texels a voxel: y: of near ones, at the first scale,
  // z: of the blend map
  vec4 material_scale;
  ivec4 material_repeat;  // x: log2 of voxels that a repeat covers, at the first scale; y: scales - 2
  // Limits of the normal's y: the way through the low one is y + value * x, that through the high one
  // z - value * x; w: how far noise moves both.
  vec4 material_slope[KARST_MOST_MATERIALS];
  vec4 material_height[KARST_MOST_MATERIALS];  // xyz: the same of the height, voxels; w: cover in caves
  vec4 material_average[KARST_MOST_MATERIALS];  // rgb: albedo, a: roughness, of all of it seen from afar
  // rgb: how much albedo follows brightness; w: how much the normal's y counts for what plane is looked up
  vec4 material_tint[KARST_MOST_MATERIALS];
  // What a texel of the near array stands for, factor and offset: xy: of brightness, zw: of slopes.
  vec4 material_near[KARST_MOST_MATERIALS];
  vec4 material_blend[KARST_MOST_MATERIALS];  // 1 for the channel of the blend map that paints it, else 0
  vec4 material_blend_place;  // place in the blend map over a column: xz * xy + zw, x and z in voxels
};
