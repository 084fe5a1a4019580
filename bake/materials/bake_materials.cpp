// SPDX-License-Identifier: MIT
#include "bake/materials/bake_materials.h"

#include "bake/base/parallel.h"
#include "bake/carve/cave_lights.h"
#include "bake/materials/material_files.h"
#include "bake/procedural/sample_materials.h"
#include "bake/textures/texture_pyramid.h"

#include <algorithm>
#include <cstring>

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

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  if (slash == std::string::npos) return {};
  return slash == 0 ? "/" : path.substr(0, slash);
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
  std::vector<std::string> images;
  MaterialFile file;
  if (options.none || options.path.empty() || !read_material_file(options.path, file).ok()) return images;
  const std::string folder = folder_of(options.path);
  for (const MaterialSpec& spec : file.materials) {
    for (const std::string* name : {&spec.albedo, &spec.height, &spec.normal, &spec.roughness}) {
      if (!name->empty()) images.push_back(path_in(folder, *name));
    }
  }
  return images;
}

Error BakeMaterials::load() {
  if (options.none || options.path.empty()) return {};
  if (Error error = read_material_file(options.path, file_); !error.ok()) return error;
  const std::string folder = folder_of(options.path);
  for (std::size_t k = 0; k < file_.materials.size(); ++k) {
    images_.emplace_back();
    if (!file_.materials[k].sample.empty()) continue;
    const Error error = read_material_image(file_.materials[k], folder, side(), images_[k]);
    if (!error.ok()) return options.path + ": material " + std::to_string(k) + ": " + error.text();
  }
  return {};
}

// A patch has the material of the last box that its middle lies in.
Error BakeMaterials::paint(BakedMaterials& baked) const {
  if (file_.paint.empty()) return {};
  baked.overrides.assign(surface.patches.size(), 0);
  for (std::size_t b = 0; b < file_.paint.size(); ++b) {
    const PaintBox& box = file_.paint[b];
    const Material* const end = baked.set.materials + baked.set.count;
    const Material* const found = std::find_if(static_cast<const Material*>(baked.set.materials), end,
                                               [&](const Material& m) { return box.material == m.name; });
    if (found == end) {
      return options.path + ": paint " + std::to_string(b) + ": material: there is no '" + box.material + "'";
    }
    const auto number = static_cast<std::uint8_t>(found - baked.set.materials + 1);
    const glm::dvec3 low = to_voxels(box.centre_m - 0.5 * box.size_m);
    const glm::dvec3 high = to_voxels(box.centre_m + 0.5 * box.size_m);
    for (std::size_t p = 0; p < surface.patches.size(); ++p) {
      const Volume& volume = surface.volumes[surface.patches[p].volume];
      bool in = true;
      for (int axis = 0; axis < 3; ++axis) {
        const double middle =
            volume.corner[axis] + 0.5 * (bounds[p].min[axis] + bounds[p].max[axis]) / kStepsPerVoxel;
        in = in && middle >= low[axis] && middle <= high[axis];
      }
      if (in) baked.overrides[p] = number;
    }
  }
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

Error BakeMaterials::run(BakedMaterials& baked) const {
  baked = BakedMaterials();
  if (options.none) return {};
  const std::vector<MaterialSpec> specs = list(baked.set);
  baked.set.side = static_cast<std::uint32_t>(side());
  baked.set.repeat_log2 = log2_of(file_.repeat_m.value_or(kRepeatM) / grid.voxel_m);
  baked.set.format = options.format.value_or(file_.format.value_or(kDefaultTextureFormat));
  if (Error error = paint(baked); !error.ok()) return error;
  light(baked);
  std::vector<MaterialImage> images = images_;
  images.resize(specs.size());
  parallel_chunks(specs.size(), 1, threads, [&](std::size_t k, std::size_t, int) {
    if (!specs[k].sample.empty()) images[k] = make_sample_material(specs[k].sample, side());
  });
  baked.textures = MakeTextures{images, threads}.run(baked.set, baked.loss);
  return {};
}

}  // namespace karst::bake
