// SPDX-License-Identifier: MIT
// A file that is read piece by piece, for worlds larger than memory.
#pragma once

#include <string>

#include "terrain/file/byte_source.h"

namespace karst::app {
using namespace core;

class FileSource {
 public:
  FileSource() = default;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource();

  // Returns an empty string on success, else one line that names the file and the cause. Only regular files
  // can be opened.
  [[nodiscard]] std::string open(const std::string& path);

  // Borrows this object. Reading fails where the file has become shorter.
  ByteSource source() const;

 private:
  int file_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace karst::app
