// SPDX-License-Identifier: MIT
#include "terrain/base/arena.h"

namespace karst::core {

void* Arena::take(Consumer consumer, std::size_t bytes) {
  const bool aligned = reinterpret_cast<std::uintptr_t>(memory_.data()) % kAlignment == 0;
  if (frozen_ || !aligned || bytes > memory_.size() - used_) return nullptr;
  std::byte* block = memory_.data() + used_;
  used_ += bytes;
  by_consumer_[static_cast<std::size_t>(consumer)] += bytes;
  return block;
}

}  // namespace karst::core
