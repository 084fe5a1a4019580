// SPDX-License-Identifier: MIT
#include "app/common/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace karst::app {
namespace {

std::string failure(const std::string& path, int error) {
  return path + ": cannot read: " + std::strerror(error);
}

}  // namespace

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

std::string MappedFile::open(const std::string& path) {
  // Without O_NONBLOCK, opening a pipe would wait for a writer.
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return failure(path, errno);
  std::string error;
  struct stat info {};
  if (fstat(file, &info) != 0) {
    error = failure(path, errno);
  } else if (S_ISDIR(info.st_mode)) {
    error = failure(path, EISDIR);
  } else if (!S_ISREG(info.st_mode)) {
    error = path + ": cannot read: not a regular file";
  } else if (info.st_size == 0) {
    error = path + ": the file is empty";
  } else {
    const auto size = static_cast<std::size_t>(info.st_size);
    void* mapped = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file, 0);
    if (mapped == MAP_FAILED) {
      error = failure(path, errno);
    } else {
      bytes_ = {static_cast<const std::byte*>(mapped), size};
    }
  }
  ::close(file);
  return error;
}

}  // namespace karst::app
