// SPDX-License-Identifier: MIT
// A file's bytes, mapped read-only: no copy, and no memory sized by what a file claims.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "platform/base/error.h"

namespace karst::app {

class MappedFile {
 public:
  MappedFile() = default;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();

  // The error names the file and the cause. Only regular files
  // can be opened. A file that somebody cuts short while it is mapped ends the program: replace files, do not
  // rewrite them.
  Error open(const std::string& path);

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace karst::app
