// SPDX-License-Identifier: MIT
// Files that are written whole or not at all: temporary file in the same folder, fsync, rename, fsync of the
// folder. Errors name the file and the cause.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "platform/base/error.h"

namespace karst::app {

// Tells, before long work, whether write_file_atomic(path) can be expected to succeed: the folder exists and
// takes a new file, and path is not a folder. Leaves nothing behind.
Error check_writable(const std::string& path);

// Replaces path by bytes. A symbolic link is followed; a device or pipe (/dev/stdout) is written directly. On
// failure path is what it was before and no temporary file is left.
Error write_file_atomic(const std::string& path, std::span<const std::byte> bytes);

}  // namespace karst::app
