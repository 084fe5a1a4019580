// SPDX-License-Identifier: MIT
#include "app/files/output_place.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstring>

namespace karst::app {
namespace {

constexpr int kMostLinks = 40;  // as the kernel has it

Error failure(const std::string& path, int error) {
  return path + ": cannot write: " + std::strerror(error);
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

// What tells two files apart. Of one that is not there: its folder's numbers and its name.
struct Identity {
  bool known = false;
  dev_t device = 0;
  ino_t inode = 0;
  std::string name;

  friend bool operator==(const Identity&, const Identity&) = default;
};

Identity identity_of(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) == 0) return {S_ISREG(info.st_mode), info.st_dev, info.st_ino, {}};
  OutputPlace place;
  if (!find_output(path, place).ok() || stat(place.folder.c_str(), &info) != 0) return {};
  return {true, info.st_dev, info.st_ino, place.name};
}

bool is_named(const NamedFile& file) {
  return !file.path.empty() && file.path != "-";
}

}  // namespace

Error find_output(const std::string& path, OutputPlace& place) {
  if (path.empty()) return "output file name is empty";
  struct stat info {};
  const bool exists = stat(path.c_str(), &info) == 0;
  if (!exists && errno != ENOENT) return failure(path, errno);
  if (exists && S_ISDIR(info.st_mode)) return failure(path, EISDIR);
  place.direct = exists && !S_ISREG(info.st_mode);
  std::string target = path;
  for (int links = 0;; ++links) {
    if (target.back() == '/') return failure(path, EISDIR);
    if (lstat(target.c_str(), &info) != 0 || !S_ISLNK(info.st_mode)) break;
    if (links == kMostLinks) return failure(path, ELOOP);
    if (info.st_uid != geteuid() && info.st_uid != 0) {
      return path + ": cannot write: " + target + " is a symbolic link of another user; name its target";
    }
    char text[PATH_MAX];
    const ssize_t length = readlink(target.c_str(), text, sizeof text);
    if (length <= 0) return failure(path, length < 0 ? errno : ENOENT);
    const std::string next(text, static_cast<std::size_t>(length));
    target = next.front() == '/' ? next : folder_of(target) + "/" + next;
  }
  place.folder = folder_of(target);
  place.name = target.substr(target.rfind('/') + 1);
  return {};
}

Error check_outputs_apart(std::span<const NamedFile> outputs, std::span<const NamedFile> inputs) {
  for (std::size_t n = 0; n < outputs.size(); ++n) {
    if (!is_named(outputs[n])) continue;
    const Identity identity = identity_of(outputs[n].path);
    if (!identity.known) continue;
    const auto same = [&](const NamedFile& other) {
      return is_named(other) && identity_of(other.path) == identity;
    };
    for (const NamedFile& input : inputs) {
      if (same(input))
        return outputs[n].what + ": " + outputs[n].path + " is also " + input.what + "; name another file";
    }
    for (const NamedFile& other : outputs.first(n)) {
      if (same(other))
        return outputs[n].what + ": " + outputs[n].path + " is also " + other.what + "; name another file";
    }
  }
  return {};
}

}  // namespace karst::app
