// SPDX-License-Identifier: MIT
#include "app/edit/journal_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "app/files/regular_file.h"

namespace karst::app {
namespace {

constexpr std::uint64_t kMostBytes = 256ull << 20;
constexpr std::uint64_t kFnvBasis = 0xcbf29ce484222325u, kFnvPrime = 0x100000001b3u;

std::uint64_t fnv(std::span<const std::byte> bytes) {
  std::uint64_t hash = kFnvBasis;
  for (const std::byte byte : bytes) hash = (hash ^ std::to_integer<std::uint64_t>(byte)) * kFnvPrime;
  return hash;
}

std::string hex(std::uint64_t value) {
  char room[17];
  std::snprintf(room, sizeof room, "%016llx", static_cast<unsigned long long>(value));
  return room;
}

// A line ends with its checksum: {...,"check":"0123456789abcdef"}
constexpr std::string_view kCheck = ",\"check\":\"";
constexpr std::size_t kTail = kCheck.size() + 16 + 2;

std::string with_check(std::string line) {
  line.pop_back();  // the bracket
  const std::uint64_t check = fnv(std::as_bytes(std::span(line)));
  return line + std::string(kCheck) + hex(check) + "\"}";
}

bool is_whole(std::string_view line) {
  if (line.size() < kTail || line.front() != '{') return false;
  const std::string_view text = line.substr(0, line.size() - kTail);
  return line.substr(text.size(), kCheck.size()) == kCheck &&
         line.substr(text.size() + kCheck.size(), 16) == hex(fnv(std::as_bytes(std::span(text)))) &&
         line.ends_with("\"}");
}

std::string head_line(std::uint64_t id) {
  return "{\"journal\":1,\"world\":\"" + hex(id) + "\"}";
}
std::string saving_line(std::uint64_t id) {
  return "{\"saving\":\"" + hex(id) + "\"}";
}

std::string failure(const std::string& path, const char* what, int error) {
  return path + ": cannot " + what + ": " + std::strerror(error);
}

Error read_all(const std::string& path, int file, std::string& text) {
  struct stat info {};
  if (fstat(file, &info) != 0) return failure(path, "read", errno);
  if (!S_ISREG(info.st_mode)) return path + ": cannot be a journal: not a regular file";
  if (static_cast<std::uint64_t>(info.st_size) > kMostBytes) return path + ": longer than 256 MiB";
  text.resize(static_cast<std::size_t>(info.st_size));
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = pread(file, text.data() + done, text.size() - done, static_cast<off_t>(done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(path, "read", errno);
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  text.resize(done);
  return {};
}

// Opens or makes the journal, for this process alone. file: to be closed, on an error too, where it is not
// -1.
Error open_locked(const std::string& path, const std::string& world, int& file) {
  constexpr int kAttempts = 100;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0666);
    if (file < 0) return failure(path, "write", errno);
    if (flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      return world + ": is being edited by another karst";
    // An editor that ended may have removed it in between.
    struct stat info {};
    if (fstat(file, &info) == 0 && info.st_nlink > 0) {
      sync_folder_of(path);
      return {};
    }
    ::close(file);
    file = -1;
  }
  return failure(path, "write", EBUSY);
}

// What a journal holds, as far as it is whole.
struct Contents {
  std::vector<ScriptStep> steps;
  bool has_head = false;
  std::string world, saved;  // ids
  std::size_t bytes = 0;     // of whole lines
};

Error read_contents(const std::string& path, std::string_view text, Contents& contents) {
  std::size_t number = 0;
  while (contents.bytes < text.size()) {
    const std::string_view rest = text.substr(contents.bytes);
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end);
    const std::string place = path + ": line " + std::to_string(++number);
    if (end == std::string_view::npos || !is_whole(line)) {
      // The last one was being written when its writer ended; of a machine that lost power it may be longer
      // than what is right of it.
      if (end == std::string_view::npos || rest.find("\n{", end) == std::string_view::npos) return {};
      return place +
             ": damaged, and lines follow: what they did cannot be done again; move the journal away "
             "to edit the world as it was saved";
    }
    if (!contents.has_head) {
      const std::string_view word = "{\"journal\":1,\"world\":\"";
      if (!line.starts_with(word)) return place + ": not a journal of edits";
      contents.world = line.substr(word.size(), 16);
      contents.has_head = true;
    } else if (line.starts_with("{\"saving\":\"")) {
      contents.saved = line.substr(11, 16);
    } else {
      contents.saved.clear();  // it was not saved: the editor went on
      if (contents.steps.size() == kMostScriptSteps) return path + ": too many edits";
      if (Error error = parse_script_line(line, place, contents.steps.emplace_back()); !error.ok())
        return error;
    }
    contents.bytes += end + 1;
  }
  return {};
}

}  // namespace

std::uint64_t world_id(std::span<const std::byte> first_bytes) {
  return fnv(first_bytes.first(std::min(first_bytes.size(), kWorldIdBytes)));
}

JournalFile::~JournalFile() {
  if (file_ >= 0) ::close(file_);
}

Error JournalFile::open(const std::string& world, std::uint64_t id, std::vector<ScriptStep>& steps,
                        std::uint64_t other) {
  steps.clear();
  path_ = path_for(world);
  int file = -1;
  Error error = open_locked(path_, world, file);
  std::string text;
  Contents contents;
  if (error.ok()) error = read_all(path_, file, text);
  if (error.ok()) error = read_contents(path_, text, contents);
  of_other_ = error.ok() && other != 0 && contents.world == hex(other) && contents.saved != hex(id);
  // Nothing may be lost that somebody might still want.
  if (error.ok() && contents.has_head && !of_other_ && contents.world != hex(id) &&
      contents.saved != hex(id) && !contents.steps.empty()) {
    error = path_ + ": holds edits of another state of " + world +
            "; move it away, or put that world back, to go on";
  }
  if (!error.ok()) {
    if (file >= 0) ::close(file);
    return error;
  }
  file_ = file;
  if (!contents.has_head || (contents.world != hex(id) && !of_other_)) return begin_anew(id);
  if (ftruncate(file_, static_cast<off_t>(contents.bytes)) != 0) return failure(path_, "write", errno);
  steps = std::move(contents.steps);
  steps_ = steps.size();
  return {};
}

Error JournalFile::put_line(std::string line, bool on_disk) {
  line = with_check(std::move(line)) + "\n";
  const off_t end = lseek(file_, 0, SEEK_END);
  int error = end < 0 ? errno : write_all(file_, std::as_bytes(std::span(line)));
  if (error == 0 && on_disk && fdatasync(file_) != 0) error = errno;
  if (error == 0) return {};
  // Half a line would end the journal for whoever reads it.
  if (end >= 0 && ftruncate(file_, end) != 0) return failure(path_, "write", errno);
  return failure(path_, "write", error);
}

Error JournalFile::append(const ScriptStep& step, bool on_disk) {
  Error error = put_line(script_line(step), on_disk);
  if (error.ok()) ++steps_;
  return error;
}

Error JournalFile::sync() {
  return fdatasync(file_) == 0 ? Error() : Error(failure(path_, "write", errno));
}

Error JournalFile::saving(std::uint64_t id) {
  return put_line(saving_line(id), true);
}

Error JournalFile::begin_anew(std::uint64_t id, bool is_other) {
  of_other_ = is_other;
  if (ftruncate(file_, 0) != 0) return failure(path_, "write", errno);
  steps_ = 0;
  return put_line(head_line(id), true);
}

Error check_not_edited(const std::string& world) {
  const int file = ::open(JournalFile::path_for(world).c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return {};
  const bool busy = flock(file, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return busy ? Error(world + ": is being edited by another karst") : Error();
}

void JournalFile::remove() {
  steps_ = 0;
  of_other_ = false;
  close();
}

void JournalFile::close() {
  if (file_ < 0) return;
  if (steps_ == 0 && !of_other_) unlink(path_.c_str());
  ::close(file_);
  file_ = -1;
}

}  // namespace karst::app
