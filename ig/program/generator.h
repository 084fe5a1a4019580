// SPDX-License-Identifier: MIT
// karst-ig: a world on a screen, as a host says, until told to stop. Everything happens in one thread: it
// sleeps until a device, a signal or the next frame wakes it. A frame reads what the host has sent, answers
// it, and is drawn.
#pragma once

#include <memory>

#include "app/common/messages.h"
#include "app/screen/screen.h"
#include "app/screen/signals.h"
#include "app/stage/stage.h"
#include "ig/draw/boxes.h"
#include "ig/link/udp_link.h"
#include "ig/program/host_state.h"
#include "ig/program/ig_options.h"

namespace karst::ig {

// What frames were like. Sizes are fixed: an IG runs for months.
struct FrameSeries {
  Series latency_ms;  // from a message's arrival to its frame being drawn, or on the screen where it tells
  Series wait_ms;     // of that, until the frame began
  Series draw_ms;     // of a frame, from its begin
  Series answer_ms;   // of that, the answers of frames that had any
  std::uint64_t frames = 0;
  std::uint64_t missed = 0;       // refreshes without a frame
  std::uint64_t most_missed = 0;  // in a row
};

class Generator {
 public:
  Generator(IgOptions options, ConsoleState& console, app::Messages& messages);
  Generator(const Generator&) = delete;
  Generator& operator=(const Generator&) = delete;
  ~Generator();

  // Returns when it was told to end, or what ended it.
  Error run();

 private:
  Error check_outputs() const;
  Error prepare();
  Error loop();
  Error attach();
  void detach();
  void wait() const;
  void take_signals();
  bool is_due(std::int64_t now) const;
  Error frame();
  Error warm_up();
  Error draw_views(std::int64_t start, app::FrameRecord& record);
  Error draw(std::int64_t start, std::int64_t arrived);
  void begin_frame_times(std::int64_t start);
  std::int64_t interval_ns() const;
  Error write_statistics() const;
  Error write_picture();
  static void draw_over(void* user, const ViewState& view, bool two_ranges);

  void say(const std::string& line) const;

  IgOptions options_;
  ConsoleState& console_;
  app::Messages& messages_;
  app::Signals signals_;
  std::unique_ptr<Seat> seat_;
  std::unique_ptr<Display> display_;  // on seat_
  app::Stage stage_;                  // in display_'s context while it is attached
  app::ContextWatch context_;
  app::CameraGround ground_;
  Query* query_ = nullptr;
  Earth earth_;
  UdpLink link_;
  HostState host_;
  Boxes boxes_;
  app::StageView view_;  // what the host does not say
  struct {
    bool lost = false;       // the context
    bool quit = false;       //
    bool paging = false;     // the last frame lacked something
    bool late = false;       // it was
    bool unread = false;     // the file could not be read
    bool has_drawn = false;  //
    bool unsent = false;     // the host was not reached
  } now_;
  struct {
    bool wanted = false;  // by SIGHUP
    std::int64_t at = 0;  // not before
  } asked_statistics_;
  std::int64_t began_ = 0, last_ = 0, next_ = 0;
  FrameSeries series_;
};

}  // namespace karst::ig
