// SPDX-License-Identifier: MIT
// karst view: a world on a screen, until told to stop. Everything happens in one thread: it sleeps until a
// device, a signal or a time limit wakes it, and draws when the picture would be another one.
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <optional>

#include "app/command_line/help.h"
#include "app/commands.h"
#include "app/common/arguments.h"
#include "app/common/atomic_file.h"
#include "app/common/json_writer.h"
#include "app/common/mapped_file.h"
#include "app/common/status_text.h"
#include "app/options/scene_settings.h"
#include "app/view/camera_ground.h"
#include "app/view/frame_scheduler.h"
#include "app/view/pose_stream.h"
#include "app/view/view_options.h"
#include "app/view/view_statistics.h"
#include "platform/base/clock.h"
#include "platform/headless/headless_display.h"
#include "platform/kms/card/kms_outputs.h"
#include "platform/seat/seat_input.h"
#include "platform/window/window_display.h"

namespace karst::app {
namespace {

constexpr int kMostPollFds = 16;
constexpr unsigned kNoReset = 0;     // GL_NO_ERROR
constexpr double kStepVoxels = 0.5;  // what a walker climbs without noticing
constexpr double kGenerateMs = 4;    // time a frame to make vertices, where the options say nothing

void say(const std::string& line) {
  print_error("karst view", line);
  std::fflush(stderr);
}

// SIGTERM, SIGINT and SIGHUP as a descriptor. They are blocked from the first line on, so that none ends the
// program before the console is given back.
class Signals {
 public:
  Signals() {
    sigset_t awaited;
    sigemptyset(&awaited);
    for (const int number : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&awaited, number);
    sigprocmask(SIG_BLOCK, &awaited, nullptr);
    fd_ = signalfd(-1, &awaited, SFD_CLOEXEC | SFD_NONBLOCK);
    signal(SIGPIPE, SIG_IGN);
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;
  ~Signals() {
    if (fd_ >= 0) close(fd_);
  }
  int fd() const { return fd_; }
  // The next signal that came, 0: none.
  int take() const {
    signalfd_siginfo info{};
    return read(fd_, &info, sizeof info) == sizeof info ? static_cast<int>(info.ssi_signo) : 0;
  }

 private:
  int fd_ = -1;
};

class View {
 public:
  View(ViewOptions options, ConsoleState& console)
      : options_(std::move(options)),
        console_(console),
        view_(view_settings(options_.scene)),
        clock_{.fixed = options_.fixed_clock},
        scheduler_(clock_) {
    if (options_.scene.generate_ms < 0) view_.generate_ms = kGenerateMs;
    view_.wait = false;
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;
  ~View() { detach(); }

  // Empty when it was told to end, else one line for the user.
  std::string run() {
    began_ = now_ns();
    if (std::string error = read_path(); !error.empty()) return error;
    if (std::string error = scene_.load(scene_settings(options_.scene, options_.world)); !error.empty())
      return error;
    if (std::string error = open_display(); !error.empty()) return error;
    if (std::string error = open_inputs(); !error.empty()) return error;
    std::string error = loop();
    if (const std::string written = write_statistics(); error.empty()) error = written;
    return error;
  }

 private:
  std::string read_path();
  std::string open_display();
  std::string open_inputs();
  std::string loop();
  std::string attach();
  void detach();
  std::string first_place();
  std::string stand_on_ground(CameraPlace& place);
  void wait();
  void take_signals();
  void take_inputs();
  bool take_pose(CameraPlace pose);
  bool play_path();
  std::string draw();
  std::string draw_scene(const Camera& camera);
  bool context_is_lost();
  bool over() const;
  std::string write_statistics();

  ViewOptions options_;
  ConsoleState& console_;
  Signals signals_;
  std::unique_ptr<Seat> seat_;
  std::unique_ptr<Input> input_;      // of seat_
  std::unique_ptr<Display> display_;  // on seat_
  Scene scene_;                       // in display_'s context while attached_
  bool attached_ = false;
  std::optional<CameraGround> ground_;
  std::optional<Navigator> navigator_;
  PoseStream poses_;
  std::vector<CameraPlace> path_;
  std::size_t path_frame_ = 0;
  SceneView view_;  // the camera aside, the same for all frames
  FrameScheduler::Settings clock_;
  FrameScheduler scheduler_;
  ViewStatistics statistics_;
  CameraPlace place_;
  bool placed_ = false;
  bool said_no_ground_ = false;
  bool vertices_lost_ = false;  // by the driver, which happens where the screen's mode changes
  bool seat_was_active_ = true;
  bool quit_ = false;
  std::int64_t began_ = 0;
  std::int64_t moved_at_ = 0;
  unsigned (*reset_status_)() = nullptr;
};

std::string View::read_path() {
  if (options_.camera.path_file.empty()) return {};
  MappedFile file;
  if (std::string error = file.open(options_.camera.path_file); !error.empty()) return error;
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  return parse_camera_path(text, options_.camera.path_file, path_);
}

std::string View::open_display() {
  std::string error;
  switch (options_.output) {
    case ViewOptions::Output::headless:
      display_ = open_headless_display({}, error);
      break;
    case ViewOptions::Output::window:
      display_ = open_window_display({options_.scene.width, options_.scene.height}, "karst", error);
      break;
    case ViewOptions::Output::kms:
      seat_ = open_seat(options_.seat, &console_, say, error);
      if (seat_ != nullptr) display_ = open_kms_display(options_.kms, *seat_, console_, say, error);
      break;
  }
  return error;
}

std::string View::open_inputs() {
  if (!options_.poses.empty()) {
    if (std::string error = poses_.open(options_.poses, say); !error.empty()) return error;
  }
  if (options_.navigate == NavigatorMode::none || seat_ == nullptr) return {};
  std::string error;
  input_ = open_input(*seat_, say, error);
  if (input_ == nullptr) say(error + "; the camera is not moved by hand");
  return {};
}

// --- the loop

std::string View::loop() {
  while (!quit_ && !over()) {
    wait();
    take_signals();
    const Display::Changes changes = display_->dispatch();
    quit_ = quit_ || changes.quit;
    if (changes.rebuild) detach();
    if (changes.redraw || changes.rebuild) scheduler_.changed();
    take_inputs();
    if (!attached_ && display_->ready()) {
      if (std::string error = attach(); !error.empty()) return error;
    }
    if (attached_ && scheduler_.due(now_ns(), display_->ready(), display_->refresh_ns())) {
      if (std::string error = draw(); !error.empty()) return error;
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
  const bool plays = options_.loop ? !path_.empty() : path_frame_ + 1 < path_.size();
  scheduler_.set_moving(attached_ && (plays || navigator_->moving() || options_.frames > 0));
  std::array<pollfd, kMostPollFds> fds{};
  std::size_t count = display_->poll_fds(std::span(fds).first(Display::kMostFds));
  const auto add = [&](int fd) {
    if (fd >= 0) fds[count++] = {fd, POLLIN, 0};
  };
  add(signals_.fd());
  add(poses_.fd());
  add(input_ != nullptr ? input_->fd() : -1);
  std::int64_t until =
      std::min(display_->deadline_ns(), scheduler_.wake_at(display_->ready(), display_->refresh_ns()));
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

void View::take_signals() {
  while (const int number = signals_.take()) {
    if (number != SIGHUP) {
      quit_ = true;
    } else if (const std::string error = write_statistics(); !error.empty()) {
      say(error);
    }
  }
}

void View::take_inputs() {
  if (seat_ != nullptr && input_ != nullptr && seat_->active() != seat_was_active_) {
    seat_was_active_ = seat_->active();
    input_->set_active(seat_was_active_);
  }
  CameraPlace pose;
  bool changed = poses_.dispatch(pose) && take_pose(pose);
  if (changed) {
    placed_ = true;
    if (navigator_) navigator_->set_place(place_);
  }
  if (Input* input = input_ != nullptr ? input_.get() : display_->input(); input != nullptr) {
    input->dispatch([&](const InputEvent& event) {
      if (!navigator_) return;
      const bool was_moving = navigator_->moving();
      if (navigator_->handle(turned(event, options_.kms.quarter_turns))) changed = true;
      if (!was_moving && navigator_->moving()) moved_at_ = now_ns();
    });
  }
  if (changed && !placed_ && navigator_) place_ = navigator_->place();
  if (changed) scheduler_.changed();
}

// A pose that counts from the ground waits for the world: first_place() comes with it.
bool View::take_pose(CameraPlace pose) {
  if (ground_) {
    if (const std::string error = ground_->stand(pose); !error.empty()) {
      if (!said_no_ground_) say("--poses: " + error);
      said_no_ground_ = true;
      return false;
    }
  }
  place_ = pose;
  return true;
}

// --- the scene

std::string View::attach() {
  Display::Size size = display_->size();
  if (size.width == 0) size = {options_.scene.width, options_.scene.height};
  if (Error error = display_->make_current(); !error.ok()) return error.text();
  if (std::string error = scene_.attach(*display_, size.width, size.height); !error.empty()) return error;
  attached_ = true;
  // GL_KHR_robustness: where the driver tells of lost contexts. The address alone says nothing; a driver
  // without the extension gives none or one that always says that all is well.
  reset_status_ = reinterpret_cast<unsigned (*)()>(display_->gl_function("glGetGraphicsResetStatusKHR"));
  if (reset_status_ == nullptr) {
    reset_status_ = reinterpret_cast<unsigned (*)()>(display_->gl_function("glGetGraphicsResetStatusEXT"));
  }
  scheduler_.changed();
  return navigator_ ? std::string() : first_place();
}

void View::detach() {
  if (!attached_) return;
  attached_ = false;
  // With a lost context, or none, deleting has no effect and is not needed.
  scene_.detach();
}

// Where the first picture is taken from; an error where that counts from ground that is not there.
std::string View::first_place() {
  const WorldFrame frame = scene_.frame();
  const LatticeBox box = scene_.terrain().box();
  const glm::dvec3 low = glm::dvec3(box.min) / static_cast<double>(kStepsPerVoxel);
  const glm::dvec3 high = glm::dvec3(box.max) / static_cast<double>(kStepsPerVoxel);
  const double size = std::max(high.x - low.x, high.z - low.z);
  ground_.emplace(scene_.terrain(), frame);
  for (std::size_t i = 0; i < path_.size(); ++i) {
    if (const std::string error = ground_->stand(path_[i]); !error.empty())
      return options_.camera.path_file + ": frame " + std::to_string(i) + ": " + error;
  }
  // A pose that came before the world was there and has no ground to stand on is left out, like later ones.
  if (placed_) placed_ = take_pose(place_);
  const char* what = "--poses";
  if (!placed_) {
    what = "--camera";
    place_ =
        options_.camera.has_camera ? options_.camera.camera : overview(frame, box, options_.scene.fov_y_deg);
    if (!path_.empty()) what = options_.camera.path_file.c_str();
    if (!path_.empty()) place_ = path_.front();
  }
  placed_ = false;
  if (const std::string error = ground_->stand(place_); !error.empty())
    return std::string(what) + ": " + error;
  if (const std::string rock = ground_->in_rock(place_); !rock.empty()) say(std::string(what) + ": " + rock);
  set_haze(options_.scene, box, view_.light);
  NavigatorSettings settings;
  settings.mode = options_.navigate;
  settings.start = place_;
  settings.centre_m = frame.origin_m + 0.5 * (low + high) * frame.voxel_size_m;
  settings.speed_m_s = 0.1 * size * frame.voxel_size_m;  // across the world in ten seconds
  settings.ground_m = [this, frame](const glm::dvec3& place_m) {
    return ground_->below_m(place_m, kStepVoxels * frame.voxel_size_m, Ground::kFeetLevel);
  };
  navigator_.emplace(std::move(settings));
  place_ = navigator_->place();
  return {};
}

bool View::play_path() {
  if (path_.empty()) return false;
  const double line = scheduler_.time_s() * options_.path_hz + 1e-6;
  auto frame = static_cast<std::size_t>(line);
  if (options_.loop) frame %= path_.size();
  frame = std::min(frame, path_.size() - 1);
  path_frame_ = frame;
  place_ = path_[frame];
  navigator_->set_place(place_);
  return true;
}

std::string View::draw() {
  const std::int64_t start = now_ns();
  display_->begin_frame(start);
  scheduler_.begin(start);
  if (!play_path() && navigator_->moving()) {
    const double seconds =
        clock_.fixed ? static_cast<double>(clock_.step_ns) * 1e-9 : ms_between(moved_at_, start) * 1e-3;
    navigator_->advance(seconds);
    moved_at_ = start;
    place_ = navigator_->place();
  }
  placed_ = false;
  Display::Size size = display_->size();
  if (size.width == 0) size = {options_.scene.width, options_.scene.height};
  const bool on_its_side = (display_->quarter_turns() & 1) != 0;
  const double aspect = on_its_side ? static_cast<double>(size.height) / size.width
                                    : static_cast<double>(size.width) / size.height;
  Camera camera;
  const Status placed =
      place_camera(place_, scene_.frame(), scene_.terrain().box(), options_.scene.fov_y_deg, aspect, camera);
  if (!placed.ok()) {  // a pose far outside: the picture stays as it is
    say(status_text("camera", placed));
    return {};
  }
  if (std::string error = draw_scene(camera); !error.empty()) return error;
  if (vertices_lost_) {
    detach();
    return {};
  }
  scene_.renderer().present();
  const std::int64_t drawn = now_ns();
  if (context_is_lost()) {
    display_->context_lost();
    return {};
  }
  std::string error = display_->present().text();
  statistics_.add_frame(ms_between(start, drawn), ms_between(drawn, now_ns()));
  return error;
}

std::string View::draw_scene(const Camera& camera) {
  view_.camera = camera;
  view_.quarter_turns = display_->quarter_turns();
  FrameRecord record;
  std::string error = scene_.draw(view_, record);
  vertices_lost_ = record.counts.vertices_lost;
  // Drawn coarser than wanted, or more was made meanwhile: the next picture is better.
  if ((record.flags & kFlagGenerate) != 0) scheduler_.changed();
  return error;
}

bool View::context_is_lost() {
  return reset_status_ != nullptr && reset_status_() != kNoReset;
}

std::string View::write_statistics() {
  if (options_.stats.empty()) return {};
  const std::string text = statistics_.json(*display_, scene_, poses_.lines());
  if (options_.stats == "-") {
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
    return {};
  }
  return write_file_atomic(options_.stats, std::as_bytes(std::span(text)));
}

// --- listing

int print_outputs(const ViewOptions& options) {
  // Listing takes no terminal: whoever holds the screen keeps it.
  std::unique_ptr<Seat> seat = open_device_access();
  std::vector<std::string> reasons;
  const std::vector<KmsOutputInfo> outputs = list_outputs(*seat, options.kms.card, reasons);
  for (const std::string& reason : reasons) say(reason);
  JsonWriter json;
  json.begin_array();
  for (const KmsOutputInfo& output : outputs) {
    json.begin_object()
        .field("card", std::string_view(output.card))
        .field("driver", std::string_view(output.driver));
    json.field("connector", std::string_view(output.connector)).field("connected", output.connected);
    json.field("width_mm", output.width_mm).field("height_mm", output.height_mm).key("modes").begin_array();
    if (!options.json) {
      std::printf("%s %s %s %s\n", output.card.c_str(), output.driver.c_str(), output.connector.c_str(),
                  output.connected ? "connected" : "disconnected");
    }
    for (const drmModeModeInfo& mode : output.modes) {
      const bool preferred = (mode.type & DRM_MODE_TYPE_PREFERRED) != 0;
      json.begin_object().field("width", int{mode.hdisplay}).field("height", int{mode.vdisplay});
      json.field("refresh_hz", refresh_hz(mode)).field("preferred", preferred).end_object();
      if (!options.json) std::printf("  %s%s\n", mode_text(mode).c_str(), preferred ? " preferred" : "");
    }
    json.end_array().end_object();
  }
  json.end_array();
  if (options.json) std::fputs(json.text().c_str(), stdout);
  return outputs.empty() ? kExitFailure : kExitOk;
}

}  // namespace

int run_view(std::span<const char* const> words) {
  CommandLine line;
  ViewOptions options;
  if (const std::string usage = parse_view_options(words, line, options); !usage.empty()) {
    print_error("karst view", usage);
    return kExitUsage;
  }
  if (line.wants_help()) {
    std::fputs(help_text(kViewSpec).c_str(), stdout);
    return kExitOk;
  }
  if (options.list_outputs) return print_outputs(options);
  ConsoleState own;
  ConsoleState* console = &own;
  if (options.output == ViewOptions::Output::kms && options.supervise) {
    if (ConsoleState* shared = share_console_state(); shared != nullptr) console = shared;
    if (const int code = supervise(*console, say); code >= 0) return code;
  }
  std::string error = View(std::move(options), *console).run();
  if (!error.empty()) {
    print_error("karst view", error);
    return kExitFailure;
  }
  return kExitOk;
}

}  // namespace karst::app
