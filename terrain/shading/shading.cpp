// SPDX-License-Identifier: MIT
#include "terrain/shading/shading.h"

#include <algorithm>
#include <cmath>

namespace karst::core {

float most_along(const NormalCone& cone, glm::vec3 direction) {
  if (cone.sine == NormalCone::kNone) return 1.0f;
  const float x = cone.axis[0];
  const float y = cone.axis[1];
  const float z = cone.axis[2];
  const float length = std::sqrt(x * x + y * y + z * z);
  const float sine = std::min(NormalCone::kSineUnit * static_cast<float>(cone.sine) / length, 1.0f);
  const float cosine = std::sqrt(1.0f - sine * sine);
  const float along = (x * direction.x + y * direction.y + z * direction.z) / length;
  if (along >= cosine) return 1.0f;
  return along * cosine + std::sqrt(std::max(1.0f - along * along, 0.0f)) * sine;
}

}  // namespace karst::core
