// SPDX-License-Identifier: MIT
// A file's bytes, read once into memory: what somebody writes to it later, or cuts off, changes nothing here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "platform/base/error.h"

namespace karst::app {

class WholeFile {
 public:
  // Paths of cameras, profiles of boards, JSON.
  static constexpr std::uint64_t kMostText = 64ull << 20;
  // PNG pictures; and worlds that are measured in memory.
  static constexpr std::uint64_t kMostBytes = 4ull << 30;

  // The error names the file and the cause. Only regular files of at most most_bytes can be opened: memory is
  // taken for no more than that.
  Error open(const std::string& path, std::uint64_t most_bytes);

  std::span<const std::byte> bytes() const { return {memory_.get(), size_}; }
  std::string_view text() const { return {reinterpret_cast<const char*>(memory_.get()), size_}; }

 private:
  std::unique_ptr<std::byte[]> memory_;
  std::size_t size_ = 0;
};

}  // namespace karst::app
