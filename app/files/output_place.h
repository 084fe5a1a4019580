// SPDX-License-Identifier: MIT
// Where an output really goes, and whether it would destroy an input or another output.
#pragma once

#include <span>
#include <string>

#include "platform/base/error.h"

namespace karst::app {

// Of a name as the user gave it, with symbolic links followed.
struct OutputPlace {
  std::string folder;   // that holds it
  std::string name;     // in the folder
  bool direct = false;  // a device or pipe: a rename would replace it by a file
};

// Refused: an empty name, a folder, links of other users (root aside).
Error find_output(const std::string& path, OutputPlace& place);

// A file that a command reads or writes, and what messages call it: "--stats".
struct NamedFile {
  std::string what;
  std::string path;  // empty, or "-": none
};

// Refuses an output that is one of the inputs or another output, by whatever name: files that exist are the
// same by device and inode, others by folder and name. Devices and pipes may be named more than once.
Error check_outputs_apart(std::span<const NamedFile> outputs, std::span<const NamedFile> inputs);

}  // namespace karst::app
