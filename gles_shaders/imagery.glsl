// SPDX-License-Identifier: MIT
// Images over the ground (terrain/imagery/imagery.h): which tile a pixel lies in, by its place from the eye,
// and what that has there. Near the eye, where a texel covers several pixels, the ground's materials add
// their brightness and bumps.
uniform KARST_MEDIUM sampler2DArray image_tiles;  // rgb: albedo, decoded from sRGB; a: how much it covers
uniform highp usampler2D image_table;             // image_view.h: windows of all sizes, views side by side

struct Image {
  KARST_MEDIUM vec4 albedo;
  KARST_MEDIUM float blur;  // how many levels of detail a texel is coarser than the pixel
};

// place: tiles of size 0 from the centre's corner. lod: of the texels that are as wide as the pixel.
Image image_at(vec2 place, float lod) {
  const int kHalf = KARST_IMAGE_WINDOW / 2;
  // The least size whose window reaches so far.
  float away = max(abs(place.x), abs(place.y)) / float(kHalf - 1);
  float wanted = max(floor(lod), ceil(log2(max(away, 1e-6))));
  int size = clamp(int(wanted), image_sizes.x, image_sizes.y);
  ivec2 centre = image_centre.xy;
  vec2 at = (vec2(centre & KARST_MASK(size)) + place) * exp2(-float(size));  // tiles of the size
  ivec2 tile = ivec2(floor(at));
  if (any(lessThan(tile, ivec2(-kHalf))) || any(greaterThanEqual(tile, ivec2(kHalf))))
    return Image(vec4(0.0), 0.0);
  ivec2 in_table = tile + kHalf + KARST_IMAGE_WINDOW * ivec2(image_sizes.z, size);
  KARST_COUNT_LOOKUPS(1);
  int entry = int(texelFetch(image_table, in_table, 0).x);
  if (entry == 0) return Image(vec4(0.0), 0.0);
  int layer = (entry & KARST_MASK(KARST_IMAGE_LAYER_BITS)) - 1;
  int coarser = entry >> KARST_IMAGE_LAYER_BITS;
  ivec2 among = ((centre >> size) + tile) & KARST_MASK(coarser);
  vec2 in_tile = (vec2(among) + at - floor(at)) * exp2(-float(coarser));
  vec2 texel = (in_tile * KARST_IMAGE_INSIDE + KARST_IMAGE_BORDER) /
               (KARST_IMAGE_INSIDE + 2.0 * KARST_IMAGE_BORDER);
  float finer = lod - float(size + coarser);
  KARST_COUNT_LOOKUPS(1);
  return Image(textureLod(image_tiles, vec3(texel, float(layer)), max(finer, 0.0)), -finer);
}

// voxels: what the pixel covers.
#ifdef KARST_CURVED
// Texels are as wide as they are there: of longitudes less and less towards the poles.
Image image_on_curve(vec2 place, vec3 from_eye, float voxels) {
  vec3 along_x = dFdx(from_eye), along_y = dFdy(from_eye);
  vec2 place_x = dFdx(place), place_y = dFdy(place);
  float xx = dot(along_x, along_x), xy = dot(along_x, along_y), yy = dot(along_y, along_y);
  vec2 squares = place_x * place_x * yy - 2.0 * place_x * place_y * xy + place_y * place_y * xx;
  float area2 = max(xx * yy - xy * xy, 1e-4 * xx * yy);
  float tiles_a_voxel = sqrt(max(max(squares.x, squares.y), 0.0) / max(area2, 1e-30));
  return image_at(place, log2(max(voxels * tiles_a_voxel * KARST_IMAGE_INSIDE, 1e-9)));
}
#else
Image image_on_plane(vec3 from_eye, float voxels) {
  return image_at(image_eye.xy + from_eye.xz * image_scale.xy, log2(voxels * image_scale.z));
}
#endif

// average: albedo of the materials there, seen from afar. What faces down or lies in a cave is not seen from
// above.
void lay_image(inout Surface ground, KARST_MEDIUM vec3 average, Image image, float upwards, float cave) {
  KARST_MEDIUM float covers = image.albedo.a * clamp(1.0 + 5.0 * upwards, 0.0, 1.0) * (1.0 - cave);
  KARST_MEDIUM float detail = smoothstep(0.0, KARST_IMAGE_FADE, image.blur);
  KARST_MEDIUM float brightness = dot(ground.albedo, kLuminance) / max(dot(average, kLuminance), 1e-3);
  KARST_MEDIUM vec3 albedo = min(image.albedo.rgb * mix(1.0, brightness, detail), vec3(1.0));
  ground.albedo = mix(ground.albedo, albedo, covers);
  ground.gradient *= mix(1.0, detail, covers);
}
