// SPDX-License-Identifier: MIT
#include "app/files/whole_file.h"

#include <unistd.h>

#include <cerrno>
#include <new>
#include <utility>

#include "app/files/regular_file.h"

namespace karst::app {

Error WholeFile::open(const std::string& path, std::uint64_t most_bytes) {
  memory_.reset();
  size_ = 0;
  int file = -1;
  std::uint64_t bytes = 0;
  if (Error error = open_regular_file(path, file, bytes); !error.ok()) return error;
  Error error;
  std::unique_ptr<std::byte[]> memory;
  if (bytes > most_bytes) {
    error = path + ": " + std::to_string(bytes) + " bytes, more than the " + std::to_string(most_bytes) +
            " that are read of such a file";
  } else {
    memory.reset(new (std::nothrow) std::byte[static_cast<std::size_t>(bytes)]);
    if (memory == nullptr) error = path + ": no memory for its " + std::to_string(bytes) + " bytes";
  }
  for (std::size_t done = 0; error.ok() && done < bytes;) {
    const ssize_t got = ::read(file, memory.get() + done, static_cast<std::size_t>(bytes) - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      error = read_failure(path, errno);
    } else if (got == 0) {
      error = path + ": it was cut short while it was read; try again";
    } else {
      done += static_cast<std::size_t>(got);
    }
  }
  ::close(file);
  if (!error.ok()) return error;
  memory_ = std::move(memory);
  size_ = static_cast<std::size_t>(bytes);
  return {};
}

}  // namespace karst::app
