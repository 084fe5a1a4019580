// SPDX-License-Identifier: MIT
// The properties of one KMS object, by name. An id of 0 means that the driver has no such property: it must
// never reach a request, where the kernel would take it for a mistake of ours at best.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "platform/base/error.h"

namespace karst {

class KmsProperties {
 public:
  Error read(int fd, std::uint32_t object, std::uint32_t object_type);

  std::uint32_t id(std::string_view name) const;     // 0: there is none
  std::uint64_t value(std::string_view name) const;  // 0 where there is none
  // Bits of a bitmask property (rotation) that the driver offers.
  std::uint64_t bits(std::string_view name) const;

 private:
  struct Property {
    std::string name;
    std::uint32_t id;
    std::uint64_t value;
    std::uint64_t bits;
  };
  const Property* find(std::string_view name) const;
  std::vector<Property> properties_;
};

}  // namespace karst
