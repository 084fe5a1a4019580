// SPDX-License-Identifier: MIT
#include "bake/materials/material_rules.h"

#include <algorithm>
#include <cstring>

#include "bake/procedural/sample_materials.h"
#include "terrain/base/check.h"

namespace karst::bake {
namespace {

// Elevation images with less relief have no ground cold enough for snow.
constexpr double kSnowReliefM = 900;

Material named(std::string_view name) {
  Material material;
  std::memcpy(material.name, name.data(), std::min(name.size(), sizeof material.name - 1));
  return material;
}

// Heights as shares of the relief, of the lowest and the highest ground.
class Rules {
 public:
  explicit Rules(const WorldRelief& relief)
      : relief_(relief), span_(std::max(relief.high - relief.low, 1.0f)) {}

  std::vector<Material> make() const {
    // Sand lies on the floors of caves, too.
    if (relief_.sample == "caves") return {rock(), grass(0.84f), strata(0.6f), ceiling(), sand(0.82f, 0.42f)};
    if (relief_.sample == "arches") return {rock(), sand(0.72f, 2), strata(0.62f), ceiling()};
    if (relief_.sample == "canyon")
      return {rock(), grass(0.84f), sand(0.78f, 0.16f), strata(0.72f), ceiling()};
    std::vector<Material> list = {rock(), grass(0.8f), sand(0.9f, 0.06f), strata(0.5f)};
    if (relief_.sample.empty() && span_ * relief_.voxel_m >= kSnowReliefM) list.push_back(snow());
    list.push_back(ceiling());
    return list;
  }

  Material by_name(std::string_view name) const {
    if (name == "grass") return grass(0.8f);
    if (name == "sand") return sand(0.85f, 0.12f);
    if (name == "strata") return strata(0.6f);
    if (name == "snow") return snow();
    if (name == "ceiling") return ceiling();
    return rock();
  }

 private:
  float height(float share) const { return relief_.low + share * span_; }

  Material rock() const { return named("rock"); }
  Material grass(float slope) const {
    Material m = named("grass");
    m.slope_low = slope;
    m.slope_soft = 0.1f;
    m.fray = 0.8f;
    return m;
  }
  Material sand(float slope, float share) const {
    Material m = named("sand");
    m.slope_low = slope;
    m.slope_soft = 0.08f;
    if (share <= 1) {
      m.height_high = height(share);
      m.height_soft = std::max(0.03f * span_, 0.3f);
    }
    m.fray = 0.6f;
    return m;
  }
  Material strata(float slope) const {
    Material m = named("strata");
    m.slope_high = slope;
    m.slope_soft = 0.1f;
    m.fray = 0.5f;
    return m;
  }
  Material snow() const {
    Material m = named("snow");
    m.slope_low = 0.72f;
    m.slope_soft = 0.12f;
    m.height_low = height(0.72f);
    m.height_soft = std::max(0.08f * span_, 0.3f);
    m.fray = 0.8f;
    return m;
  }
  Material ceiling() const {
    Material m = named("ceiling");
    m.slope_high = m.slope_low;  // in caves only
    m.cave = 1;
    return m;
  }

  WorldRelief relief_;
  float span_;
};

}  // namespace

std::vector<Material> default_materials(const WorldRelief& relief) {
  return Rules(relief).make();
}

Material default_material(std::string_view name, const WorldRelief& relief) {
  KARST_ASSERT(is_sample_material(name));
  return Rules(relief).by_name(name);
}

}  // namespace karst::bake
