// SPDX-License-Identifier: MIT
// A file that is read piece by piece, for worlds larger than memory.
#pragma once

#include <string>

#include "karst/types.h"
#include "platform/base/error.h"

namespace karst::app {

class FileSource {
 public:
  FileSource() = default;
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource();

  // The error names the file and the cause. Only regular files
  // can be opened.
  Error open(const std::string& path);

  // Borrows this object. Reading fails where the file has become shorter, and after stop_reading().
  Source source();

  // Of all sources of the program, from any thread: reads that begin from now on fail at once.
  static void stop_reading();
  static bool is_stopped();
  // Whether some thread is in a read.
  static bool is_reading();

 private:
  int file_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace karst::app
