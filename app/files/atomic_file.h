// SPDX-License-Identifier: MIT
// Files that are written whole or not at all: temporary file in the same folder, fsync, rename, fsync of the
// folder. Errors name the file and the cause.
//
// A symbolic link is followed to the file that it names, which is replaced and may be new; a link that
// belongs to another user (root aside) is refused. A file that is replaced keeps its mode. A device or pipe
// (/dev/stdout) is written directly.
//
// Temporary files are named .karst-PROCESS-N.tmp, whatever the file's own name. SIGINT, SIGTERM and SIGHUP
// remove the one that is being written. One that a killed process left is known by its lock, which ended with
// the process.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "platform/base/error.h"

namespace karst::app {

// Tells, before long work, whether write_file_atomic(path) can be expected to succeed: the folder exists and
// takes a new file, and path is not a folder. Leaves nothing behind, and removes this user's temporary files
// in the folder that nobody writes any more.
Error check_writable(const std::string& path);

// Replaces path by bytes. On failure path is what it was before and no temporary file is left. One thread at
// a time.
Error write_file_atomic(const std::string& path, std::span<const std::byte> bytes);

// The same, piece by piece: path is replaced by commit(), and is what it was before where that is not called.
// One at a time. Devices and pipes are refused.
class AtomicFile {
 public:
  AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  Error open(const std::string& path);
  // offset: from the file's beginning; what nobody writes is 0.
  Error write(std::uint64_t offset, std::span<const std::byte> bytes);
  Error commit();

 private:
  struct Open;
  std::unique_ptr<Open> open_;
};

}  // namespace karst::app
