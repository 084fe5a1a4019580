// SPDX-License-Identifier: MIT
#include "bake/materials/bake_materials.h"

#include "bake/base/parallel.h"
#include "bake/carve/cave_lights.h"
#include "bake/materials/material_files.h"
#include "bake/procedural/sample_materials.h"
#include "bake/textures/texture_pyramid.h"
#include "platform/base/text.h"
#include "terrain/shading/painted_texels.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace karst::bake {
namespace {

// Limits that say "no limit", outside of every slope and height.
constexpr float kNoSlope = 2;
constexpr float kNoHeight = 1e6f;
// A limit's softness where a material file does not say.
constexpr float kSlopeSoft = 0.1f;
constexpr float kHeightSoft = 1;
// What the procedural images show is of this width: blades of 4 to 10 cm, wind ripples of 12 cm.
constexpr double kRepeatM = 2;
constexpr std::size_t kMostDefault = 6;  // default_materials, with snow

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash == std::string::npos) return {};
  return slash == 0 ? "/" : path.substr(0, slash);
}

// As often as they are named.
std::vector<std::string> images_of(const MaterialFile& file, const std::string& folder) {
  std::vector<std::string> images;
  for (const MaterialSpec& spec : file.materials) {
    for (const std::string* name : {&spec.albedo, &spec.height, &spec.normal, &spec.roughness}) {
      if (!name->empty()) images.push_back(path_in(folder, *name));
    }
  }
  if (file.blend_map) images.push_back(path_in(folder, file.blend_map->image));
  return images;
}

// The nearest power of two, as a file may state it.
std::int32_t log2_of(double repeat_voxels) {
  std::int32_t log2 = 0;
  for (; repeat_voxels > 1.41421356 && log2 < kMostRepeatLog2; ++log2) repeat_voxels /= 2;
  for (; repeat_voxels < 0.70710678 && log2 > kLeastRepeatLog2; --log2) repeat_voxels *= 2;
  return log2;
}

float within(double value, float most) {
  return static_cast<float>(std::clamp(value, -double{most}, double{most}));
}

}  // namespace

WorldRelief BakeMaterials::relief() const {
  if (heights) return {sample, (*heights)[0], (*heights)[1], grid.voxel_m};
  const auto [low, high] =
      std::minmax_element(surface.volumes.begin(), surface.volumes.end(),
                          [](const Volume& a, const Volume& b) { return a.corner[1] < b.corner[1]; });
  return {sample, static_cast<float>(low->corner[1]), static_cast<float>(high->corner[1]), grid.voxel_m};
}

Material BakeMaterials::resolve(const MaterialSpec& spec) const {
  Material material;
  material.slope_soft = kSlopeSoft;
  material.height_soft = kHeightSoft;
  if (!spec.sample.empty()) material = default_material(spec.sample, relief());
  std::memset(material.name, 0, sizeof material.name);
  std::memcpy(material.name, spec.name.data(), spec.name.size());
  if (spec.slope) {
    material.slope_low = static_cast<float>((*spec.slope)[0].value_or(-kNoSlope));
    material.slope_high = static_cast<float>((*spec.slope)[1].value_or(kNoSlope));
  }
  if (spec.elevation) {
    const auto height = [&](std::optional<double> y_m, float otherwise) {
      return y_m ? within((*y_m - grid.origin_m.y) / grid.voxel_m, kNoHeight) : otherwise;
    };
    material.height_low = height((*spec.elevation)[0], -kNoHeight);
    material.height_high = height((*spec.elevation)[1], kNoHeight);
  }
  if (spec.slope_soft) material.slope_soft = static_cast<float>(*spec.slope_soft);
  if (spec.elevation_soft)
    material.height_soft = std::max(within(*spec.elevation_soft / grid.voxel_m, kNoHeight), 1e-3f);
  if (spec.cave) material.cave = static_cast<float>(*spec.cave);
  if (spec.fray) material.fray = static_cast<float>(*spec.fray);
  return material;
}

std::vector<std::string> material_images(const MaterialOptions& options) {
  MaterialFile file;
  if (options.none || options.path.empty() || !read_material_file(options.path, file).ok()) return {};
  return images_of(file, folder_of(options.path));
}

// The textures' texels, where the file says how many.
Error BakeMaterials::check_side() const {
  const std::size_t count = file_.materials.empty() ? kMostDefault : file_.materials.size();
  const auto texels = static_cast<std::size_t>(side()) * static_cast<std::size_t>(side());
  if (options.side || count * texels <= kMostFileTexels) return {};
  const std::string number = std::to_string(side());
  return options.path + ": side: " + number + " x " + number + " texels of " + std::to_string(count) +
         " materials are more than " + std::to_string(kMostFileTexels) + "; --material-side " + number +
         " allows them";
}

Error BakeMaterials::load() {
  if (options.none || options.path.empty()) return {};
  if (Error error = read_material_file(options.path, file_); !error.ok()) return error;
  const std::string folder = folder_of(options.path);
  if (Error error = check_side(); !error.ok()) return error;
  TexelBudget budget(images_of(file_, folder), options.max_texels);
  for (std::size_t k = 0; k < file_.materials.size(); ++k) {
    images_.emplace_back();
    if (!file_.materials[k].sample.empty()) continue;
    const Error error = read_material_image(file_.materials[k], folder, side(), budget, images_[k]);
    if (!error.ok()) return options.path + ": material " + std::to_string(k) + ": " + error.text();
  }
  if (!file_.blend_map) return {};
  const Error error = read_blend_map(path_in(folder, file_.blend_map->image),
                                     file_.blend_map->materials.size(), budget, map_, map_texels_);
  return error.ok() ? error : options.path + ": blend_map: " + error.text();
}

// The number of the material of that name, or -1.
int BakeMaterials::number_of(const MaterialSet& set, const std::string& name) {
  for (std::uint32_t m = 0; m < set.count; ++m) {
    if (name == set.materials[m].name) return static_cast<int>(m);
  }
  return -1;
}

// Weights of channels that have a material, together 255 at most.
Error BakeMaterials::blend(BakedMaterials& baked) const {
  if (!file_.blend_map) return {};
  BlendMap& map = baked.set.blend_map = map_;
  const std::vector<std::string>& names = file_.blend_map->materials;
  for (std::size_t channel = 0; channel < names.size(); ++channel) {
    const int number = number_of(baked.set, names[channel]);
    if (number < 0) return options.path + ": blend_map: materials: there is no " + quote(names[channel]);
    map.materials[channel] = static_cast<std::uint8_t>(number + 1);
  }
  baked.blend_map = map_texels_;
  for (std::size_t texel = 0; texel < baked.blend_map.size(); texel += kBlendTexelBytes) {
    const std::span<std::byte> weights = std::span(baked.blend_map).subspan(texel, kBlendTexelBytes);
    unsigned sum = 0;
    for (std::size_t c = 0; c < kBlendTexelBytes; ++c) {
      if (c >= names.size()) weights[c] = std::byte{0};
      sum += std::to_integer<unsigned>(weights[c]);
    }
    if (sum <= 255) continue;
    for (std::byte& weight : weights)
      weight = static_cast<std::byte>(std::to_integer<unsigned>(weight) * 255 / sum);
  }
  mark_painted(baked);
  return {};
}

// Patches without a material of their own that the weights of some painted texel reach.
void BakeMaterials::mark_painted(BakedMaterials& baked) const {
  const BlendMap& map = baked.set.blend_map;
  baked.overrides.resize(surface.patches.size(), 0);
  // Texels that are painted left of and above each, so that any rectangle's are known at once.
  const std::size_t stride = map.width + 1;
  std::vector<std::uint32_t> before(stride * (map.depth + 1), 0);
  for (std::size_t y = 0; y < map.depth; ++y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      const std::byte* texel = baked.blend_map.data() + (y * map.width + x) * kBlendTexelBytes;
      const bool painted =
          std::any_of(texel, texel + kBlendTexelBytes, [](std::byte b) { return b != std::byte{0}; });
      before[(y + 1) * stride + x + 1] = (painted ? 1u : 0u) + before[y * stride + x + 1] +
                                         before[(y + 1) * stride + x] - before[y * stride + x];
    }
  }
  const BlendSpan span = BlendSpan::of_voxels(grid.extent);
  for (std::size_t p = 0; p < surface.patches.size(); ++p) {
    if (baked.overrides[p] != 0) continue;
    const Volume& volume = surface.volumes[surface.patches[p].volume];
    const auto side = [&](int axis, bool high) {
      return volume.corner[axis] +
             static_cast<double>((high ? bounds[p].max : bounds[p].min)[axis]) / kStepsPerVoxel;
    };
    const TexelRect r =
        texels_reaching(map, span, {side(0, false), side(2, false)}, {side(0, true), side(2, true)});
    const std::uint32_t count = before[r.high.y * stride + r.high.x] - before[r.low.y * stride + r.high.x] -
                                before[r.high.y * stride + r.low.x] + before[r.low.y * stride + r.low.x];
    if (count == 0) continue;
    baked.overrides[p] = kPaintedByMap;
    ++baked.under_map;
  }
}

// A patch has the material of the last box that its middle lies in.
Error BakeMaterials::paint(BakedMaterials& baked) const {
  if (file_.paint.empty()) return {};
  baked.overrides.assign(surface.patches.size(), 0);
  struct Painted {
    glm::dvec3 low, high;  // voxels
    std::uint8_t number;
  };
  std::vector<Painted> boxes;
  for (std::size_t b = 0; b < file_.paint.size(); ++b) {
    const PaintBox& box = file_.paint[b];
    const int found = number_of(baked.set, box.material);
    if (found < 0) {
      return options.path + ": paint " + std::to_string(b) + ": material: there is no " + quote(box.material);
    }
    boxes.push_back({to_voxels(box.centre_m - 0.5 * box.size_m), to_voxels(box.centre_m + 0.5 * box.size_m),
                     static_cast<std::uint8_t>(found + 1)});
  }
  parallel_chunks(surface.patches.size(), 256, threads, [&](std::size_t first, std::size_t last, int) {
    for (std::size_t p = first; p < last; ++p) {
      const Volume& volume = surface.volumes[surface.patches[p].volume];
      glm::dvec3 middle;
      for (int axis = 0; axis < 3; ++axis) {
        middle[axis] =
            volume.corner[axis] + 0.5 * (bounds[p].min[axis] + bounds[p].max[axis]) / kStepsPerVoxel;
      }
      const auto in = [&middle](const Painted& box) {
        return middle.x >= box.low.x && middle.x <= box.high.x && middle.y >= box.low.y &&
               middle.y <= box.high.y && middle.z >= box.low.z && middle.z <= box.high.z;
      };
      const auto box = std::find_if(boxes.rbegin(), boxes.rend(), in);
      if (box != boxes.rend()) baked.overrides[p] = box->number;
    }
  });
  baked.painted = static_cast<std::size_t>(
      std::count_if(baked.overrides.begin(), baked.overrides.end(), [](std::uint8_t m) { return m != 0; }));
  return {};
}

void BakeMaterials::light(BakedMaterials& baked) const {
  if (!file_.lights) {
    if (sample == "caves") baked.lights = PlaceCaveLights{octree, grid.extent}.run();
    return;
  }
  for (const LightSpec& spec : *file_.lights) {
    PointLight light;
    light.position = glm::vec3(to_voxels(spec.position_m));
    light.radius = static_cast<float>(spec.radius_m / grid.voxel_m);
    light.colour = glm::vec3(spec.colour);
    baked.lights.push_back(light);
  }
}

// The materials with their rules, and where their images come from.
std::vector<MaterialSpec> BakeMaterials::list(MaterialSet& set) const {
  if (!file_.materials.empty()) {
    for (const MaterialSpec& spec : file_.materials) set.materials[set.count++] = resolve(spec);
    return file_.materials;
  }
  std::vector<MaterialSpec> specs;
  for (const Material& material : default_materials(relief())) {
    MaterialSpec spec;
    spec.name = spec.sample = material.name;
    specs.push_back(spec);
    set.materials[set.count++] = material;
  }
  return specs;
}

Error BakeMaterials::outline(BakedMaterials& baked) const {
  baked = BakedMaterials();
  if (options.none) return {};
  list(baked.set);
  baked.set.side = static_cast<std::uint32_t>(side());
  baked.set.repeat_log2 = log2_of(file_.repeat_m.value_or(kRepeatM) / grid.voxel_m);
  baked.set.format = options.format.value_or(file_.format.value_or(kDefaultTextureFormat));
  if (Error error = paint(baked); !error.ok()) return error;
  if (Error error = blend(baked); !error.ok()) return error;
  light(baked);
  return {};
}

Error BakeMaterials::run(BakedMaterials& baked) {
  if (Error error = outline(baked); !error.ok() || options.none) return error;
  MaterialSet listed;
  const std::vector<MaterialSpec> specs = list(listed);
  std::vector<MaterialImage> images = std::move(images_);
  images.resize(specs.size());
  // Which material has the same sample first: it is painted once.
  std::vector<std::size_t> first(specs.size());
  for (std::size_t k = 0; k < specs.size(); ++k) {
    const auto same = [&](const MaterialSpec& other) { return other.sample == specs[k].sample; };
    first[k] = static_cast<std::size_t>(std::find_if(specs.begin(), specs.end(), same) - specs.begin());
  }
  parallel_chunks(specs.size(), 1, threads, [&](std::size_t k, std::size_t, int) {
    if (!specs[k].sample.empty() && first[k] == k) images[k] = make_sample_material(specs[k].sample, side());
  });
  for (std::size_t k = 0; k < specs.size(); ++k) {
    if (!specs[k].sample.empty() && first[k] != k) images[k] = images[first[k]];
  }
  baked.textures = MakeTextures{images, threads}.run(baked.set, baked.loss);
  return {};
}

}  // namespace karst::bake
