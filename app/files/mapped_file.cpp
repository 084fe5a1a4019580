// SPDX-License-Identifier: MIT
#include "app/files/mapped_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>

#include "app/files/regular_file.h"

namespace karst::app {

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

Error MappedFile::open(const std::string& path) {
  int file = -1;
  std::uint64_t bytes = 0;
  if (Error error = open_regular_file(path, file, bytes); !error.ok()) return error;
  const auto size = static_cast<std::size_t>(bytes);
  void* mapped = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
  const int error = errno;
  ::close(file);
  if (mapped == MAP_FAILED) return read_failure(path, error);
  bytes_ = {static_cast<const std::byte*>(mapped), size};
  return {};
}

}  // namespace karst::app
