// SPDX-License-Identifier: MIT
#include "platform/kms/pipe/kms_properties.h"

#include <xf86drmMode.h>

#include <cerrno>

#include "platform/base/log.h"

namespace karst {

Error KmsProperties::read(int fd, std::uint32_t object, std::uint32_t object_type) {
  properties_.clear();
  drmModeObjectPropertiesPtr list = drmModeObjectGetProperties(fd, object, object_type);
  if (list == nullptr) return errno_text("drmModeObjectGetProperties", errno);
  Error error;
  for (std::uint32_t i = 0; i < list->count_props && error.ok(); ++i) {
    drmModePropertyPtr property = drmModeGetProperty(fd, list->props[i]);
    if (property == nullptr) {
      error = errno_text("drmModeGetProperty", errno);
      break;
    }
    std::uint64_t bits = 0;
    for (int e = 0; e < property->count_enums; ++e) {
      if (property->enums[e].value < 64) bits |= std::uint64_t{1} << property->enums[e].value;
    }
    properties_.push_back({property->name, property->prop_id, list->prop_values[i], bits});
    drmModeFreeProperty(property);
  }
  drmModeFreeObjectProperties(list);
  return error;
}

const KmsProperties::Property* KmsProperties::find(std::string_view name) const {
  for (const Property& property : properties_) {
    if (property.name == name) return &property;
  }
  return nullptr;
}

std::uint32_t KmsProperties::id(std::string_view name) const {
  const Property* property = find(name);
  return property != nullptr ? property->id : 0;
}

std::uint64_t KmsProperties::value(std::string_view name) const {
  const Property* property = find(name);
  return property != nullptr ? property->value : 0;
}

std::uint64_t KmsProperties::bits(std::string_view name) const {
  const Property* property = find(name);
  return property != nullptr ? property->bits : 0;
}

}  // namespace karst
