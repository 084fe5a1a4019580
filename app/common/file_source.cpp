// SPDX-License-Identifier: MIT
#include "app/common/file_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace karst::app {
namespace {

std::string failure(const std::string& path, int error) {
  return path + ": cannot read: " + std::strerror(error);
}

bool read_all(int file, std::uint64_t offset, std::span<std::byte> out) {
  while (!out.empty()) {
    const ssize_t got = pread(file, out.data(), out.size(), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    offset += static_cast<std::uint64_t>(got);
    out = out.subspan(static_cast<std::size_t>(got));
  }
  return true;
}

}  // namespace

FileSource::~FileSource() {
  if (file_ >= 0) ::close(file_);
}

std::string FileSource::open(const std::string& path) {
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
    if (file_ >= 0) ::close(file_);
    file_ = file;
    bytes_ = static_cast<std::uint64_t>(info.st_size);
    return {};
  }
  ::close(file);
  return error;
}

ByteSource FileSource::source() const {
  return {bytes_, this, [](const void* context, std::uint64_t offset, std::span<std::byte> out) {
            return read_all(static_cast<const FileSource*>(context)->file_, offset, out);
          }};
}

}  // namespace karst::app
