// SPDX-License-Identifier: MIT
#include "bake/base/scratch_grid.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace karst::bake {
namespace {

// A file that no folder names, or -1 and errno.
int unnamed_file(const std::string& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return file;
  // Where the file system has none.
  std::string name = folder + "/.karst-scratch-XXXXXX";
  const int named = mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) unlink(name.c_str());
  return named;
}

}  // namespace

Error ScratchGrid::open(std::int64_t width, std::int64_t height, std::uint64_t held_bytes,
                        const std::string& folder) {
  clear();
  squares_wide_ = squares(width);
  const std::uint64_t bytes = bytes_for(width, height);
  if (bytes <= held_bytes) {
    held_.resize(static_cast<std::size_t>(bytes / sizeof(float)));
    numbers_ = held_.data();
    return {};
  }
  const auto failure = [&](int error) {
    return Error(folder + ": takes " + std::to_string((bytes >> 20) + 1) +
                 " MiB while elevation this large is laid on a cube, and cannot: " + std::strerror(error));
  };
  const int file = unnamed_file(folder);
  if (file < 0) return failure(errno);
  const int full = posix_fallocate(file, 0, static_cast<off_t>(bytes));
  if (full != 0) {
    close(file);
    return failure(full);
  }
  void* const at =
      mmap(nullptr, static_cast<std::size_t>(bytes), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  const int error = errno;
  close(file);
  if (at == MAP_FAILED) return failure(error);
  numbers_ = static_cast<float*>(at);
  mapped_bytes_ = static_cast<std::size_t>(bytes);
  return {};
}

void ScratchGrid::clear() {
  if (mapped_bytes_ > 0) munmap(numbers_, mapped_bytes_);
  mapped_bytes_ = 0;
  numbers_ = nullptr;
  held_ = {};
}

}  // namespace karst::bake
