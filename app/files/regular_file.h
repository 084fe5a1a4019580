// SPDX-License-Identifier: MIT
// Opening files that are there to be read as a whole or in pieces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "platform/base/error.h"

namespace karst::app {

// Opens a regular file that is not empty. file: a descriptor that the caller closes. The
// error names the file and the cause.
Error open_regular_file(const std::string& path, int& file, std::uint64_t& bytes);

// path: cannot read: what errno says.
std::string read_failure(const std::string& path, int error);

// Makes what was created or renamed in the file's folder durable. Some file systems refuse that; nothing is
// lost then but the name, where power fails soon.
void sync_folder_of(const std::string& path);

// Writes all of it, whatever interrupts. 0, or an errno.
int write_all(int file, std::span<const std::byte> bytes);

}  // namespace karst::app
