// SPDX-License-Identifier: MIT
// Materials: which of them lie where (K 4.2.3), their textures by tri-planar mapping (K 4.2.1, equations 4.4
// and 4.5) at two scales (K 4.2.2) of a ladder, and how their bumps turn the normal.
//
// What a pixel does not need is skipped, and changes no bit of it, because it would be multiplied by zero: a
// plane of weight zero, the second of two materials where one covers all, the near scale where it has faded.

// TextureArray, terrain/shading/materials.h; MaterialBlock says what near texels stand for.
uniform KARST_MEDIUM sampler2DArray far_textures;   // rgb: albedo, sRGB; a: roughness
uniform KARST_MEDIUM sampler2DArray near_textures;  // r: brightness; g: height, 0..1; ba: slope along s and t
#ifdef KARST_BLEND
uniform KARST_MEDIUM sampler3D variation;  // r: simplex noise, K equation 4.6 (variation_texture.h)
#ifdef KARST_BLEND_MAP
uniform KARST_MEDIUM sampler2D blend_map;  // weights of up to four materials (BlendMap, materials.h)
#endif
#endif

// What a pixel covers of the ground, an ellipse. Where the device looks up its longer side in several places
// (KARST_ANISOTROPY above 1), the two half axes are known, in multiples of `voxels`: `across` is 1 long,
// `along` 1 to KARST_ANISOTROPY. Everywhere else they are not used.
struct Footprint {
  float voxels;  // side of a square that is looked up instead, or of one of the places
  vec3 across;
  vec3 along;
};

struct Surface {
  KARST_MEDIUM vec3 albedo;
  KARST_MEDIUM float height;
  KARST_MEDIUM float roughness;
  KARST_MEDIUM vec3 gradient;  // of the bumps' height, along the world's axes
};

// A pixel's places in repeats of the textures, and their levels of detail. Levels are explicit because the
// lookups lie in branches, where implicit derivatives are undefined.
//
// From near to far, the near scale's detail fades until only the far scale is left, and of that the
// brightness: near textures of the same scale have it too. They begin with it as the near ones of the
// next pair, of whose far scale the colours fade in. So no texture is looked up at a third scale.
// Without details, the far textures of the scale before are, over a level.
struct Lookup {
  vec3 near;
  vec3 far;
  float near_lod;
  float far_lod;
  float rest_lod;
  KARST_MEDIUM float detail;  // share of the near scale's detail
  KARST_MEDIUM float hue;     // share of what far textures have beside brightness
  KARST_MEDIUM float rest;    // share of what was left of the pair before
  KARST_MEDIUM float relief;  // share of bumps; what of their slopes is not seen makes the ground rougher
  KARST_MEDIUM float smoothness;
  bool details;  // whether near textures are looked up
  bool rests;    // and far ones at the near scale
  Footprint footprint;
};

// In repeats of 2^repeat_log2 voxels; whole ones are left out.
vec3 place_in(ivec3 patch_voxel, vec3 in_patch, int repeat_log2) {
  vec3 voxels = vec3(patch_voxel & ((1 << max(repeat_log2, 0)) - 1)) + in_patch;
  return voxels * intBitsToFloat((127 - repeat_log2) << 23);  // times 2^-repeat_log2
}

Lookup lookup_at(ivec3 patch_voxel, vec3 in_patch, Footprint footprint) {
  float lod = log2(footprint.voxels) + material_scale.y + KARST_SOFTEN_LEVELS;  // of near ones, first scale
  const float kLevels = float(KARST_SCALE_LOG2);
  int scale = clamp(int(floor((lod - KARST_SCALE_BEGINS) / kLevels)), 0, material_repeat.y);
  int repeat_log2 = material_repeat.x + KARST_SCALE_LOG2 * scale;
  float near_lod = lod - kLevels * float(scale);
  float detail = clamp(KARST_SCALE_BEGINS + kLevels - near_lod, 0.0, 1.0);
  float hue = scale < material_repeat.y ? min(KARST_FADE * detail, 1.0) : 1.0;
  float rest = scale == 0 ? 0.0 : clamp(1.0 + KARST_FADE * (KARST_SCALE_BEGINS - near_lod), 0.0, 1.0);
  float smoothness = clamp(1.0 - near_lod / (KARST_SCALE_BEGINS + kLevels), 0.0, 1.0);
  bool details = detail > 0.0 || least_work.z > 0;
#if KARST_DETAIL == KARST_DETAIL_LOW
  repeat_log2 -= KARST_SCALE_LOG2;
  near_lod += kLevels;
  detail = 0.0;
  details = false;
#endif
  float far_lod = near_lod - KARST_FAR_LEVELS;
  bool rests = false;
#if KARST_DETAIL == KARST_DETAIL_LOW
  rests = rest > 0.0 || least_work.z > 0;
#else
  // As blurred as the far textures that were there before.
  if (scale > 0) near_lod = max(near_lod, KARST_SCALE_BEGINS + 1.0);
#endif
#if KARST_DETAIL == KARST_DETAIL_MEDIUM
  // Which of two mips is strewn over half a level, so that no line shows where one ends: J. Jimenez, "Next
  // Generation Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014, interleaved gradient noise.
  float strewn = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  near_lod = floor(max(near_lod, 0.0) + 0.25 + 0.5 * strewn);
#endif
  return Lookup(place_in(patch_voxel, in_patch, repeat_log2),
                place_in(patch_voxel, in_patch, repeat_log2 + KARST_SCALE_LOG2), near_lod, far_lod,
                far_lod + kLevels, detail, hue, rest, detail * (1.0 - rest), smoothness * (1.0 - rest),
                details, rests, footprint);
}

// Along the world's y, t runs upwards on both upright planes, so that strata lie level.
vec2 on_plane(vec3 place, int axis) {
  return axis == 0 ? place.zy : axis == 1 ? place.xz : place.xy;
}

// The two planes that a surface is looked up on, by their axes, and the share of the second. K's weights
// (equation 4.4), |n| less epsilon, hold for up to three planes; here what is taken off is at least the least
// of |n|, so that one has none, continuously: where two planes change places both have nothing. Only at
// (1, 1, 1) does no continuous choice exist; nothing is seen there.
struct Planes {
  int first;
  int second;
  KARST_MEDIUM float second_share;  // 0..0.5
  bool both;
};

//
// level: how much the level plane's part of the normal counts for a material (material_tint). On that plane
// the strata of walls would run across those of the upright planes.
Planes planes_of(vec3 normal, float level) {
  vec3 n = abs(vec3(normal.x, normal.y * level, normal.z));
  float least = min(n.x, min(n.y, n.z));
  vec3 over = max(n - max(least, KARST_TRIPLANAR_EPSILON), 0.0);
  int a = n.x > least ? 0 : 1;
  int b = n.z > least ? 2 : 1;
  float over_a = n.x > least ? over.x : over.y;
  float over_b = n.z > least ? over.z : over.y;
  float share = (min(over_a, over_b) + 1e-4) / (over_a + over_b + 2e-4);
  bool both = min(over_a, over_b) > 0.0 || max(over_a, over_b) == 0.0;
  bool a_first = over_a >= over_b;
  return Planes(a_first ? a : b, a_first ? b : a, both ? share : 0.0, both || least_work.x > 0);
}

// Sums over planes of what the textures say, times the plane's weight.
struct Sums {
  KARST_MEDIUM vec4 far;
  KARST_MEDIUM vec2 near;
  KARST_MEDIUM vec3 gradient;
  KARST_MEDIUM vec3 rest;
};

// A fit of IEC 61966-2-1 by I. Taylor, off by 0.0015 at most; 0 and 1 stay.
KARST_MEDIUM vec3 decode_albedo(KARST_MEDIUM vec3 srgb) {
  return srgb * (srgb * (srgb * 0.305306011 + 0.682171111) + 0.012522878);
}

const KARST_MEDIUM vec3 kLuminance = vec3(0.2126, 0.7152, 0.0722);  // ITU-R BT.709

// A level of a texture of 1 / texel texels a side; with several places the one that gradients of this length
// ask for.
KARST_MEDIUM vec4 look(KARST_MEDIUM sampler2DArray textures, vec3 place, float lod, float texel,
                       Footprint footprint, int axis) {
#if KARST_ANISOTROPY > 1
  float size = exp2(lod) * texel;
  return textureGrad(textures, place, on_plane(footprint.across, axis) * size,
                     on_plane(footprint.along, axis) * size);
#else
  return textureLod(textures, place, lod);
#endif
}

void add_detail(inout Sums sums, vec3 near, Lookup at, int axis, KARST_MEDIUM float weight,
                KARST_MEDIUM vec2 decoding) {
  KARST_MEDIUM vec4 texel =
      look(near_textures, near, at.near_lod, material_scale.x, at.footprint, axis);
  sums.near += weight * texel.rg;
  // A height's slope along s and t is the surface's gradient along two of the world's axes, whichever way it
  // faces: M. Mikkelsen, "Surface Gradient Based Bump Mapping Framework", 2020.
  KARST_MEDIUM vec2 slope = weight * (texel.ba * decoding.x + decoding.y);
  sums.gradient +=
      axis == 0 ? vec3(0.0, slope.yx) : axis == 1 ? vec3(slope.x, 0.0, slope.y) : vec3(slope, 0.0);
}

void add_plane(inout Sums sums, float layer, Lookup at, int axis, KARST_MEDIUM float weight,
               KARST_MEDIUM vec2 decoding) {
  KARST_COUNT_LOOKUPS(1 + int(at.details) + int(at.rests));
  float texel = 2.0 * material_scale.x;
  vec3 far = vec3(on_plane(at.far, axis), layer);
  vec3 near = vec3(on_plane(at.near, axis), layer);
  sums.far += weight * look(far_textures, far, at.far_lod, texel, at.footprint, axis);
  if (at.details) add_detail(sums, near, at, axis, weight, decoding);
  if (at.rests)
    sums.rest += weight * look(far_textures, near, at.rest_lod, texel, at.footprint, axis).rgb;
}

Surface surface_of(int material, Lookup at, vec3 normal) {
  KARST_MEDIUM vec4 tint = material_tint[material];
  Planes planes = planes_of(normal, tint.w);
  Sums sums = Sums(vec4(0.0), vec2(0.0), vec3(0.0), vec3(0.0));
  float layer = float(material);
  KARST_MEDIUM vec4 decoding = material_near[material];
  add_plane(sums, layer, at, planes.first, 1.0 - planes.second_share, decoding.zw);
  if (planes.both) add_plane(sums, layer, at, planes.second, planes.second_share, decoding.zw);
  // The far scale brings variety, the near one detail, of which the texture's own colours follow.
  KARST_MEDIUM float brighter = (sums.near.r * decoding.x + decoding.y - 1.0) * at.detail;
  KARST_MEDIUM vec3 albedo = decode_albedo(sums.far.rgb);
  KARST_MEDIUM vec3 average = material_average[material].rgb;
#if KARST_DETAIL == KARST_DETAIL_LOW
  albedo = mix(albedo, decode_albedo(sums.rest), at.rest);
#else
  // As near textures of its scale have it.
  KARST_MEDIUM float brightness = dot(albedo, kLuminance) / dot(average, kLuminance);
  KARST_MEDIUM vec3 bright = average * (1.0 + tint.rgb * (brightness - 1.0));
  albedo = mix(mix(bright, albedo, at.hue), average, at.rest) * (1.0 + brighter * tint.rgb);
#endif
  return Surface(albedo,
                 mix(KARST_MEAN_HEIGHT, sums.near.g, at.relief),
                 mix(material_average[material].a, sums.far.a, at.smoothness), sums.gradient * at.relief);
}

#ifdef KARST_BLEND
// How far a value is on the ways through both limits, that fade: 0 before one, 1 behind it.
// limits: material_slope's or material_height's.
vec2 ways_through(float value, vec4 limits) {
  return vec2(limits.y + value * limits.x, limits.z - value * limits.x);
}

// How much lies within all limits. moved: by noise.
float within(vec4 ways, float moved) {
  vec4 way = clamp(ways + vec4(moved, -moved, moved, -moved), 0.0, 1.0);
  vec4 smooth_way = way * way * (3.0 - 2.0 * way);
  return smooth_way.x * smooth_way.y * (smooth_way.z * smooth_way.w);
}

// Painted weights over a place (K 6.2), of the materials of the blend map's channels, 1 together at most.
// They fade out towards ground that faces down and in caves: the map does not see them.
KARST_MEDIUM vec4 painted_at(vec2 place, Footprint footprint, float upwards, float cave) {
#ifdef KARST_BLEND_MAP
  KARST_COUNT_LOOKUPS(1);
  vec2 at = place * material_blend_place.xy + material_blend_place.zw;
#if KARST_ANISOTROPY > 1
  vec2 voxels = footprint.voxels * material_blend_place.xy;
  KARST_MEDIUM vec4 weights =
      textureGrad(blend_map, at, footprint.across.xz * voxels, footprint.along.xz * voxels);
#else
  KARST_MEDIUM vec4 weights = textureLod(blend_map, at, log2(footprint.voxels) + material_scale.z);
#endif
  KARST_MEDIUM float sum = dot(weights, vec4(1.0));
  return weights * (clamp(1.0 + 5.0 * upwards, 0.0, 1.0) * (1.0 - cave) / max(sum, 1.0));
#else
  return vec4(0.0);
#endif
}

struct Choice {
  int first;    // what covers most
  int second;   // what covers most of the rest
  float share;  // of the second, 0..0.5
};

// The second material shows first where it stands higher than the other. The same from both sides at 0.5,
// where the two change places; 0 for a share up to kLeastShare, however much higher it stands.
const float kLeastShare = 0.1;
KARST_MEDIUM float blend_by_height(KARST_MEDIUM float share, KARST_MEDIUM float higher) {
  KARST_MEDIUM float raised = share + 2.0 * higher * share * (1.0 - share);
  return clamp((raised - 0.5) / 0.4 + 0.5, 0.0, 1.0);
}

// Materials hide each other in order. What the third covers is taken off the first two, so that the second
// has a share of zero where another takes its place: nothing jumps. KARST_MATERIALS is a number, so that
// loops unroll and the limits are read at fixed places, each once: reading them is what costs.
//
// painted: weights of the blend map; the rules share what they leave.
// voxels: what they have besides rules lies before all else.
Choice choice_of(float slope, float height, vec3 noise_place, float cave, KARST_MEDIUM vec4 painted
#ifdef KARST_VOXEL_MATERIALS
                 , Voxels voxels
#endif
) {
  vec4 ways[KARST_MATERIALS];
  float frays[KARST_MATERIALS];
  float caves[KARST_MATERIALS];
  // Noise can move something where a way is neither behind nor ahead for all that noise does.
  float certain = 1.0;
  for (int m = 1; m < KARST_MATERIALS; ++m) {
    vec4 slopes = material_slope[m];
    vec4 heights = material_height[m];
    ways[m] = vec4(ways_through(slope, slopes), ways_through(height, heights));
    frays[m] = slopes.w;
    caves[m] = heights.w;
    vec4 from_middle = abs(ways[m] - 0.5);
    float least = min(min(from_middle.x, from_middle.y), min(from_middle.z, from_middle.w));
    certain = min(certain, least - frays[m]);
  }
  float noise = 0.0;
  if (least_work.y > 0 || certain < 0.5) {
    KARST_COUNT_LOOKUPS(1);
    noise = textureLod(variation, noise_place, 0.0).r * (255.0 / 127.0) - 128.0 / 127.0;
  }
  int first = 0;
  int second = 0;
  vec3 most = vec3(0.0);
  float left = 1.0;
#ifdef KARST_VOXEL_MATERIALS
  float by_rules = (voxels.first == 0 ? 1.0 - voxels.share : 0.0) + (voxels.second == 0 ? voxels.share : 0.0);
#endif
#ifdef KARST_BLEND_MAP
  KARST_MEDIUM float unpainted = 1.0 - dot(painted, vec4(1.0));
#endif
  for (int m = KARST_MATERIALS - 1; m >= 0; --m) {
    float covers = left * (m == 0 ? 1.0 : max(within(ways[m], noise * frays[m]), caves[m] * cave));
    left -= covers;
#ifdef KARST_BLEND_MAP
    covers = covers * unpainted + dot(painted, material_blend[m]);
#endif
#ifdef KARST_VOXEL_MATERIALS
    covers = covers * by_rules + (voxels.first == m + 1 ? 1.0 - voxels.share : 0.0) +
             (voxels.second == m + 1 ? voxels.share : 0.0);
#endif
    bool is_first = covers > most.x;
    bool is_second = covers > most.y;
    second = is_first ? first : is_second ? m : second;
    first = is_first ? m : first;
    most = is_first ? vec3(covers, most.xy)
                    : is_second ? vec3(most.x, covers, most.y) : vec3(most.xy, max(most.z, covers));
  }
  vec2 over = most.xy - most.z;
  return Choice(first, second, over.y / max(over.x + over.y, 1e-4));
}

Surface blended_surface(Choice choice, Lookup at, vec3 normal) {
  Surface first = surface_of(choice.first, at, normal);
  Surface second = first;
  if (choice.share > kLeastShare || least_work.y > 0) second = surface_of(choice.second, at, normal);
  KARST_MEDIUM float t = blend_by_height(choice.share, second.height - first.height);
  return Surface(mix(first.albedo, second.albedo, t), mix(first.height, second.height, t),
                 mix(first.roughness, second.roughness, t), mix(first.gradient, second.gradient, t));
}
#endif
