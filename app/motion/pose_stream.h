// SPDX-License-Identifier: MIT
// Camera poses from another program, a simulator say: text lines "X Y Z YAW PITCH" in metres and degrees,
// from standard input or as UDP datagrams of one line or more. The newest pose counts. Lines that are not
// poses are reported, five a second at most, and ignored.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "app/common/camera_path.h"
#include "platform/base/error.h"

namespace karst::app {

// Longer lines are no poses.
inline constexpr std::size_t kLongestPoseLine = 512;

// "-", "udp:PORT" or "udp:ADDRESS:PORT", ADDRESS being IPv4 or [IPv6]. An error where it is none.
Error check_pose_source(std::string_view text);

// Puts lines together from pieces, and tells the last pose.
class PoseLines {
 public:
  using Report = std::function<void(const std::string& line)>;
  // what: how messages name the source.
  PoseLines(std::string what, Report report) : what_(std::move(what)), report_(std::move(report)) {}

  // now_ns: for limiting reports. Returns whether a pose was among the bytes; place is then the last of them.
  bool feed(std::string_view bytes, std::int64_t now_ns, CameraPlace& place);
  // Ends the line begun, if any: a datagram ends, the input is closed.
  bool end(std::int64_t now_ns, CameraPlace& place);

  std::uint64_t poses() const { return poses_; }
  std::uint64_t malformed() const { return malformed_; }

 private:
  bool take_line(std::string_view line, std::int64_t now_ns, CameraPlace& place);
  void complain(const std::string& error, std::int64_t now_ns);

  std::string what_;
  Report report_;
  std::array<char, kLongestPoseLine> line_{};
  std::size_t length_ = 0;
  bool too_long_ = false;
  std::uint64_t poses_ = 0;
  std::uint64_t malformed_ = 0;
  std::uint64_t unreported_ = 0;
  std::int64_t second_began_ = 0;
  int reports_this_second_ = 0;
};

class PoseStream {
 public:
  PoseStream() = default;
  PoseStream(const PoseStream&) = delete;
  PoseStream& operator=(const PoseStream&) = delete;
  ~PoseStream();

  // source: as check_pose_source() accepts it.
  Error open(const std::string& source, PoseLines::Report report);
  int fd() const { return fd_; }  // -1: there is none, or it has ended
  // Reads all there is, without waiting. True where place is a new pose.
  bool dispatch(CameraPlace& place);
  const PoseLines& lines() const { return lines_; }

 private:
  PoseLines lines_{"", nullptr};
  int fd_ = -1;
  bool datagrams_ = false;
};

}  // namespace karst::app
