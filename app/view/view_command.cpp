// SPDX-License-Identifier: MIT
// karst view: a world on a screen, until told to stop. Everything happens in one thread: it sleeps until a
// device, a signal or a time limit wakes it, and draws when the picture would be another one.

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <vector>

#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/messages.h"
#include "app/editor/stage_editor.h"
#include "app/files/atomic_file.h"
#include "app/files/file_source.h"
#include "app/files/output_place.h"
#include "app/screen/screen.h"
#include "app/screen/signals.h"
#include "app/stage/camera_view.h"
#include "app/stage/stage_view.h"
#include "app/view/camera_source.h"
#include "app/view/frame_scheduler.h"
#include "app/view/view_options.h"
#include "app/view/view_statistics.h"
#include "platform/base/clock.h"
#include "platform/seat/seat_input.h"

namespace karst::app {
namespace {

constexpr int kMostPollFds = 16;
constexpr std::int64_t kStatistics_ns = 200'000'000;  // between two writings that SIGHUP asks for
constexpr std::int64_t kRetry_ns = 250'000'000;       // between two frames that hope for a file
constexpr double kGenerateMs = 4;  // time a frame to make vertices, where the options say nothing

// All that this program says while it runs goes through here.
Messages& messages() {
  static Messages all([](const std::string& line) {
    print_error("karst view", line);
    std::fflush(stderr);
  });
  return all;
}

void say(const std::string& line) {
  messages().say(line, now_ns());
}

class View {
 public:
  View(ViewOptions options, ConsoleState& console)
      : options_(std::move(options)),
        console_(console),
        signals_(options_.output != ViewOptions::Output::kms || options_.supervise),
        camera_(options_, messages()),
        scheduler_(clock()) {}
  View(const View&) = delete;
  View& operator=(const View&) = delete;
  ~View() { detach(); }

  // Returns when it was told to end, or what ended it.
  Error run() {
    began_ = now_ns();
    if (Error error = check_output(); !error.ok()) return error;
    Error error = prepare();
    if (error.ok()) error = loop();
    // After it, files cannot be read.
    if (!error.ok() && (quit_ || signals_.take().end)) error = {};
    if (display_ == nullptr) return error;
    if (Error written = write_statistics(); error.ok()) error = std::move(written);
    return error;
  }

 private:
  FrameScheduler::Settings clock() const { return {.fixed = options_.fixed_clock}; }
  Error check_output() const;
  Error prepare();
  Error load_world();
  Error open_display();
  Error open_inputs();
  Error loop();
  Error attach();
  void detach();
  void wait();
  void take_signals();
  void take_inputs();
  Error draw();
  Error draw_scene();
  bool over() const;
  Error write_statistics();

  ViewOptions options_;
  ConsoleState& console_;
  Signals signals_;
  std::unique_ptr<Seat> seat_;
  std::unique_ptr<Input> input_;      // of seat_
  std::unique_ptr<Display> display_;  // on seat_
  Stage stage_;                       // in display_'s context while it is attached
  StageEditor editor_{say};           // of stage_'s world
  CameraSource camera_;
  StageView view_;  // the camera aside, the same for all frames
  FrameScheduler scheduler_;
  ViewStatistics statistics_;
  bool lost_ = false;           // the context
  bool vertices_lost_ = false;  // by the driver, which happens where the screen's mode changes
  bool seat_was_active_ = true;
  bool quit_ = false;
  bool unread_ = false;                      // the file, in the last frame
  std::int64_t retry_at_ = Display::kNever;  // to draw again for it
  struct {
    bool wanted = false;  // by SIGHUP
    std::int64_t at = 0;  // not before
  } asked_statistics_;
  std::int64_t began_ = 0;
  ContextWatch context_;
};

Error View::check_output() const {
  std::vector<NamedFile> outputs;
  std::vector<NamedFile> inputs = files_read(options_.world, options_.scene, options_.camera);
  if (!options_.stats.empty() && options_.stats != "-") outputs.push_back({"--stats", options_.stats});
  if (!options_.edit_files.output.empty()) outputs.push_back({"--edit-out", options_.edit_files.output});
  // The world itself may be where it is saved.
  if (!options_.edit_files.output.empty())
    std::erase_if(inputs, [&](const NamedFile& file) {
      std::error_code none;
      return file.what == "WORLD" && std::filesystem::equivalent(file.path, options_.edit_files.output, none);
    });
  if (Error error = check_outputs_apart(outputs, inputs); !error.ok()) return error;
  for (const NamedFile& output : outputs) {
    if (Error error = check_writable(output.path); !error.ok()) return error;
  }
  return options_.edit && options_.edit_files.output.empty() ? check_writable(options_.world) : Error();
}

Error View::prepare() {
  if (Error error = camera_.open(); !error.ok()) return error;
  if (Error error = load_world(); !error.ok()) return error;
  if (Error error = open_display(); !error.ok()) return error;
  return open_inputs();
}

Error View::load_world() {
  if (options_.edit) {
    if (Error error = editor_.open(options_.edit_files, options_.edit_bytes); !error.ok()) return error;
  }
  const StageNeeds needs = editor_.needs({.queries = 1});
  const std::string& world = options_.edit ? editor_.base() : options_.world;
  if (Error error = stage_.load(world, options_.scene, needs); !error.ok()) return error;
  if (Error error = editor_.begin(stage_); !error.ok()) return error;
  view_ = stage_view(options_.scene, stage_.world().info());
  if (options_.scene.generate_ms < 0) view_.work_ms = kGenerateMs;
  view_.wait = false;
  return {};
}

Error View::open_display() {
  return open_screen(options_, {options_.scene.width, options_.scene.height}, "karst", console_, say, seat_,
                     display_);
}

Error View::open_inputs() {
  if (options_.navigate == NavigatorMode::none || seat_ == nullptr) return {};
  Error error;
  input_ = open_input(*seat_, say, error);
  if (input_ == nullptr) say(error.text() + "; the camera is not moved by hand");
  return {};
}

// --- the loop

Error View::loop() {
  while (!quit_ && !over()) {
    wait();
    take_signals();
    const Display::Changes changes = display_->dispatch();
    quit_ = quit_ || changes.quit;
    if (changes.rebuild) detach();
    if (changes.redraw || changes.rebuild) scheduler_.changed();
    take_inputs();
    if (now_ns() >= retry_at_) {
      scheduler_.changed();
      retry_at_ = Display::kNever;
    }
    if (!stage_.attached() && display_->ready()) {
      if (Error error = attach(); !error.ok()) return error;
    }
    if (stage_.attached() && scheduler_.due(now_ns(), display_->ready(), display_->refresh_ns())) {
      if (Error error = draw(); !error.ok()) return error;
    }
    if (options_.wait_s >= 0 && statistics_.frames() == 0 &&
        ms_between(began_, now_ns()) > options_.wait_s * 1000) {
      return "no display came within --wait";
    }
  }
  return {};
}

bool View::over() const {
  return (options_.frames > 0 && statistics_.frames() >= static_cast<std::uint64_t>(options_.frames)) ||
         (options_.seconds > 0 && ms_between(began_, now_ns()) > options_.seconds * 1000);
}

// Until something happens or is due.
void View::wait() {
  scheduler_.set_moving(stage_.attached() && (camera_.moving() || editor_.is_busy() || options_.frames > 0));
  std::array<pollfd, kMostPollFds> fds{};
  std::size_t count = display_->poll_fds(std::span(fds).first(Display::kMostFds));
  const auto add = [&](int fd) {
    if (fd >= 0) fds[count++] = {fd, POLLIN, 0};
  };
  add(signals_.fd());
  add(camera_.fd());
  add(input_ != nullptr ? input_->fd() : -1);
  std::int64_t until =
      std::min(display_->deadline_ns(), scheduler_.wake_at(display_->ready(), display_->refresh_ns()));
  if (asked_statistics_.wanted) until = std::min(until, asked_statistics_.at);
  if (stage_.attached() && display_->ready()) until = std::min(until, retry_at_);
  const auto limit = [&](double seconds) {
    until = std::min(until, began_ + static_cast<std::int64_t>(seconds * 1e9) + 1'000'000);
  };
  if (options_.seconds > 0) limit(options_.seconds);
  if (options_.wait_s >= 0 && statistics_.frames() == 0) limit(options_.wait_s);
  const std::int64_t left = until == Display::kNever ? -1 : std::max<std::int64_t>(0, until - now_ns());
  // Nanoseconds, because a whole millisecond too long is a missed refresh.
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
  ppoll(fds.data(), count, left < 0 ? nullptr : &timeout, nullptr);
}

// A flood of SIGHUP has no more written than what is asked for once in kStatistics_ns; the last is written.
void View::take_signals() {
  const Signals::Taken taken = signals_.take();
  quit_ = quit_ || taken.end;
  asked_statistics_.wanted = asked_statistics_.wanted || taken.statistics;
  if (!asked_statistics_.wanted || quit_ || now_ns() < asked_statistics_.at) return;
  if (const Error error = write_statistics(); !error.ok()) say(error.text());
  asked_statistics_.wanted = false;
  asked_statistics_.at = now_ns() + kStatistics_ns;
}

void View::take_inputs() {
  if (seat_ != nullptr && input_ != nullptr && seat_->active() != seat_was_active_) {
    seat_was_active_ = seat_->active();
    input_->set_active(seat_was_active_);
  }
  bool changed = camera_.take_poses();
  if (Input* input = input_ != nullptr ? input_.get() : display_->input(); input != nullptr) {
    input->dispatch([&](const InputEvent& event) {
      changed |= editor_.handle(turned(event, options_.kms.quarter_turns),
                                [&](const InputEvent& rest) { changed |= camera_.handle(rest, now_ns()); });
    });
  }
  if (changed) scheduler_.changed();
}

// --- the scene

Error View::attach() {
  Display::Size size = display_->size();
  if (size.width == 0) size = {options_.scene.width, options_.scene.height};
  if (Error error = display_->make_current(); !error.ok()) return error;
  if (Error error = stage_.attach(*display_, size.width, size.height); !error.ok()) return error;
  if (Error error = editor_.attach(*display_); !error.ok()) return error;
  lost_ = false;
  context_.attach(*display_);
  scheduler_.changed();
  return camera_.has_begun() ? Error() : camera_.begin(stage_.world());
}

void View::detach() {
  editor_.detach(lost_);
  stage_.detach(lost_);
}

Error View::draw() {
  const std::int64_t start = now_ns();
  display_->begin_frame(start);
  scheduler_.begin(start);
  const double step_s = options_.fixed_clock ? static_cast<double>(clock().step_ns) * 1e-9 : -1;
  const CameraPlace& place = camera_.advance(scheduler_.time_s(), start, step_s);
  Display::Size size = display_->size();
  if (size.width == 0) size = {options_.scene.width, options_.scene.height};
  const PictureShape shape{size.width, size.height, options_.scene.fov_y_deg, display_->quarter_turns(),
                           stage_.reversed_depth()};
  const Status placed =
      place_view(place, stage_.world().info(), camera_.axes(), shape, camera_.clearance_m(), view_.view);
  if (!placed.ok()) return {"camera", placed};
  editor_.before_frame(view_, display_->quarter_turns(), start);
  if (Error error = draw_scene(); !error.ok()) return error;
  if (vertices_lost_) {
    detach();
    return {};
  }
  stage_.target().present();
  const std::int64_t drawn = now_ns();
  if (context_.is_lost()) {
    lost_ = true;
    display_->context_lost();
    return {};
  }
  Error error = display_->present();
  statistics_.add_frame(ms_between(start, drawn), ms_between(drawn, now_ns()));
  return error;
}

Error View::draw_scene() {
  FrameRecord record;
  const Error error = stage_.draw(view_, record);
  vertices_lost_ = record.costs.vertices_lost;
  const bool unread = (record.result.limits & kLimitFile) != 0;
  if (unread && FileSource::is_stopped()) return error;
  if (unread && !unread_) say(options_.world + ": heights cannot be read; drawn coarser, and tried again");
  if (!unread && unread_) say(options_.world + ": heights can be read again");
  unread_ = unread;
  // Drawn coarser than wanted, or more was made meanwhile: the next picture is better. A file that cannot be
  // read is given time.
  if (unread) {
    retry_at_ = now_ns() + kRetry_ns;
  } else if ((record.result.limits & kLimitWork) != 0) {
    scheduler_.changed();
  }
  if (editor_.take_changed()) scheduler_.changed();
  return error;
}

Error View::write_statistics() {
  if (options_.stats.empty()) return {};
  const std::string text = statistics_.json(*display_, stage_, camera_.poses(), editor_.edit_ms());
  if (options_.stats == "-") {
    std::fputs(text.c_str(), stdout);
    return flush_output();
  }
  return write_file_atomic(options_.stats, std::as_bytes(std::span(text)));
}

}  // namespace

int run_view(std::span<const char* const> words) {
  CommandLine line;
  ViewOptions options;
  if (const Error usage = parse_view_options(words, line, options); !usage.ok()) {
    print_error("karst view", usage.text());
    return kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(help_text(kViewSpec).c_str(), stdout);
    return kExitOk;
  }
  if (options.list_outputs) return print_outputs(options, say);
  ConsoleState own;
  ConsoleState* console = &own;
  if (const int code = supervise_screen(options, say, console); code >= 0) return code;
  Error error = View(std::move(options), *console).run();
  if (!error.ok()) {
    print_error("karst view", error.text());
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::app
