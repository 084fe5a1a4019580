// SPDX-License-Identifier: MIT
// Camera poses from another program, a simulator say: text lines "X Y Z YAW PITCH" in metres and degrees,
// from standard input or as UDP datagrams, whose last line counts. The newest pose counts. Lines that are not
// poses are counted and ignored, and reported as often as messages may be.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "app/common/camera_path.h"
#include "app/common/messages.h"
#include "platform/base/error.h"

namespace karst::app {

// Longer lines are no poses.
inline constexpr std::size_t kLongestPoseLine = 512;

// "-", "udp:PORT" or "udp:ADDRESS:PORT", ADDRESS being IPv4 or [IPv6]. An error where it is none.
Error check_pose_source(std::string_view text);

// Puts lines together from pieces, and tells the last pose.
class PoseLines {
 public:
  // what: how messages name the source. messages: borrowed; null: nothing is said.
  explicit PoseLines(std::string what = {}, Messages* messages = nullptr)
      : what_(std::move(what)), messages_(messages) {}

  // now_ns: for limiting reports. Returns whether a pose was among the bytes; place is then the last of them.
  bool feed(std::string_view bytes, std::int64_t now_ns, CameraPlace& place);
  // Ends the line begun, if any: the input is closed.
  bool end(std::int64_t now_ns, CameraPlace& place);
  // A datagram: its last line that is not blank; those before it are older and are not looked at.
  bool datagram(std::string_view bytes, std::int64_t now_ns, CameraPlace& place);

  std::uint64_t poses() const { return poses_; }
  std::uint64_t malformed() const { return malformed_; }

 private:
  bool take_line(std::string_view line, std::int64_t now_ns, CameraPlace& place);
  void complain(std::string_view line, std::int64_t now_ns);

  std::string what_;
  Messages* messages_;
  std::array<char, kLongestPoseLine> line_{};
  std::size_t length_ = 0;
  bool too_long_ = false;
  std::uint64_t poses_ = 0;
  std::uint64_t malformed_ = 0;
};

class PoseStream {
 public:
  PoseStream() = default;
  PoseStream(const PoseStream&) = delete;
  PoseStream& operator=(const PoseStream&) = delete;
  ~PoseStream();

  // source: as check_pose_source() accepts it. messages is borrowed.
  Error open(const std::string& source, Messages& messages);
  int fd() const { return fd_; }  // -1: there is none, or it has ended
  // Reads what there is, without waiting, within a budget of bytes and time: more is left for the next call.
  // True where place is a new pose.
  bool dispatch(CameraPlace& place);
  const PoseLines& lines() const { return lines_; }

 private:
  // Bytes read, 0 at the end of the input, -1 where there is nothing to read now.
  std::ptrdiff_t read_some(char* out, std::size_t room) const;

  PoseLines lines_;
  int fd_ = -1;
  bool datagrams_ = false;
};

}  // namespace karst::app
