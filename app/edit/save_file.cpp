// SPDX-License-Identifier: MIT
#include "app/edit/save_file.h"

#include <algorithm>
#include <vector>

#include "app/common/progress.h"
#include "app/edit/journal_file.h"
#include "app/files/atomic_file.h"

namespace karst::app {
namespace {

// Pieces are small: they go to the file together.
class Writer {
 public:
  Writer(AtomicFile& file, std::uint64_t expected)
      : file_(file), shown_(expected > 0), progress_("save", expected) {
    buffer_.reserve(kBuffer);
  }

  bool add(std::span<const std::byte> bytes) {
    if (first_.size() < kWorldIdBytes) {
      const std::size_t count = std::min(bytes.size(), kWorldIdBytes - first_.size());
      first_.insert(first_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (buffer_.size() + bytes.size() > kBuffer) flush();
    if (bytes.size() >= kBuffer) {
      write(bytes);
    } else {
      buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    }
    return error_.ok();
  }
  Error finish() {
    flush();
    return error_;
  }
  std::span<const std::byte> first() const { return first_; }
  std::uint64_t bytes() const { return written_ + buffer_.size(); }
  const Error& error() const { return error_; }

 private:
  static constexpr std::size_t kBuffer = 1 << 16;

  void flush() {
    write(buffer_);
    buffer_.clear();
  }
  void write(std::span<const std::byte> bytes) {
    if (error_.ok() && !bytes.empty()) error_ = file_.write(written_, bytes);
    written_ += bytes.size();
    if (shown_) progress_.update(written_);
  }

  AtomicFile& file_;
  std::vector<std::byte> buffer_, first_;
  std::uint64_t written_ = 0;
  bool shown_;
  Progress progress_;
  Error error_;
};

}  // namespace

Error save_file(Editor& editor, const std::string& path, const SaveReady& ready, std::uint64_t& bytes,
                std::uint64_t expected) {
  AtomicFile file;
  if (Error error = file.open(path); !error.ok()) return error;
  Writer writer(file, expected);
  const Sink sink{&writer, [](void* user, std::span<const std::byte> piece) {
                    return static_cast<Writer*>(user)->add(piece);
                  }};
  const Status status = editor.save(sink);
  if (!writer.error().ok()) return writer.error();
  if (!status.ok()) return {path, status};
  if (Error error = writer.finish(); !error.ok()) return error;
  bytes = writer.bytes();
  if (ready) {
    if (Error error = ready(world_id(writer.first())); !error.ok()) return error;
  }
  return file.commit();
}

}  // namespace karst::app
