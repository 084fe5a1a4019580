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

#include "app/commands.h"
#include "app/common/atomic_file.h"
#include "app/common/json_writer.h"
#include "app/common/mapped_file.h"
#include "app/common/status_text.h"
#include "app/view/ground.h"
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
      : options_(std::move(options)), console_(console), scheduler_(options_.clock) {}
  View(const View&) = delete;
  View& operator=(const View&) = delete;
  ~View() { detach(); }

  // Empty when it was told to end, else one line for the user.
  std::string run() {
    began_ = now_ns();
    if (std::string error = read_path(); !error.empty()) return error;
    if (std::string error = scene_.load(options_.scene); !error.empty()) return error;
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
  void first_place();
  void wait();
  void take_signals();
  void take_inputs();
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
  std::optional<Ground> ground_;
  std::optional<Navigator> navigator_;
  PoseStream poses_;
  std::vector<CameraPlace> path_;
  std::size_t path_frame_ = 0;
  FrameScheduler scheduler_;
  ViewStatistics statistics_;
  CameraPlace place_;
  bool placed_ = false;
  bool vertices_lost_ = false;  // by the driver, which happens where the screen's mode changes
  bool seat_was_active_ = true;
  bool quit_ = false;
  std::int64_t began_ = 0;
  std::int64_t moved_at_ = 0;
  unsigned (*reset_status_)() = nullptr;
};

std::string View::read_path() {
  if (options_.path_file.empty()) return {};
  MappedFile file;
  if (std::string error = file.open(options_.path_file); !error.empty()) return error;
  const std::string_view text(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size());
  return parse_camera_path(text, options_.path_file, path_);
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
  bool changed = poses_.dispatch(place_);
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
  if (!navigator_) first_place();
  scheduler_.changed();
  return {};
}

void View::detach() {
  if (!attached_) return;
  attached_ = false;
  // With a lost context, or none, deleting has no effect and is not needed.
  scene_.detach();
}

void View::first_place() {
  const WorldFrame frame = scene_.frame();
  const LatticeBox box = scene_.terrain().box();
  const glm::dvec3 low = glm::dvec3(box.min) / static_cast<double>(kStepsPerVoxel);
  const glm::dvec3 high = glm::dvec3(box.max) / static_cast<double>(kStepsPerVoxel);
  const double size = std::max(high.x - low.x, high.z - low.z);
  if (!placed_) {
    place_ = options_.has_camera ? options_.camera : overview(frame, box, options_.fov_y_deg);
    if (!path_.empty()) place_ = path_.front();
  }
  placed_ = false;
  if (options_.default_haze) options_.light.haze_voxels = std::max(1.0, 6.0 * size);
  ground_.emplace(scene_.terrain());
  NavigatorSettings settings;
  settings.mode = options_.navigate;
  settings.start = place_;
  settings.centre_m = frame.origin_m + 0.5 * (low + high) * frame.voxel_size_m;
  settings.speed_m_s = 0.1 * size * frame.voxel_size_m;  // across the world in ten seconds
  settings.ground_m = [this, frame](const glm::dvec3& place_m) -> std::optional<double> {
    const glm::dvec3 voxels = (place_m - frame.origin_m) / frame.voxel_size_m;
    const std::optional<double> height = ground_->below(voxels, kStepVoxels);
    if (!height) return std::nullopt;
    return frame.origin_m.y + *height * frame.voxel_size_m;
  };
  navigator_.emplace(std::move(settings));
  place_ = navigator_->place();
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
    const double seconds = options_.clock.fixed ? static_cast<double>(options_.clock.step_ns) * 1e-9
                                                : ms_between(moved_at_, start) * 1e-3;
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
      place_camera(place_, scene_.frame(), scene_.terrain().box(), options_.fov_y_deg, aspect, camera);
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
  SceneView view;
  view.camera = camera;
  view.light = options_.light;
  view.lod = options_.lod;
  view.quarter_turns = display_->quarter_turns();
  view.generate_ms = options_.generate_ms;
  view.wait = false;
  FrameRecord record;
  std::string error = scene_.draw(view, record);
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
  Arguments arguments;
  ViewOptions options;
  if (const std::string usage = parse_view_options(words, arguments, options); !usage.empty()) {
    print_error("karst view", usage);
    return kExitUsage;
  }
  if (arguments.has("help")) {
    std::fputs(kViewHelp, stdout);
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
