// SPDX-License-Identifier: MIT
#include "ig/program/generator.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <vector>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/files/atomic_file.h"
#include "app/files/output_place.h"
#include "app/stage/resource_counts.h"
#include "app/stage/stage_view.h"
#include "platform/base/clock.h"

namespace karst::ig {
namespace {

constexpr std::int64_t kStatistics_ns = 200'000'000;  // between two writings that SIGHUP asks for
constexpr double kGenerateMs = 4;  // time a frame to make vertices, where the options say nothing
// What a query keeps of the ground: so many patches, or as many as find room in so many bytes; and 256 tiles
// of 64 samples a side, 7 MiB, which are 1,024 x 1,024 samples where they lie close together.
constexpr std::uint32_t kQueryPatches = 1024;
constexpr std::uint64_t kQueryBytes = 8 << 20;
constexpr std::uint32_t kQueryTiles = 256;
// What the first frames take that others do not is done before the host hears of one; so long at most.
constexpr std::int64_t kWarm_ns = 3'000'000'000;
constexpr int kWarmFrames = 3;

void write_series(app::JsonWriter& json, const char* name, const Series& series) {
  json.key(name).begin_object().field("median", series.percentile(0.5)).field("p99", series.percentile(0.99));
  json.field("max", series.most()).end_object();
}

}  // namespace

Generator::Generator(IgOptions options, ConsoleState& console, app::Messages& messages)
    : options_(std::move(options)),
      console_(console),
      messages_(messages),
      signals_(options_.output != app::ScreenArguments::Output::kms || options_.supervise),
      host_(options_.database, options_.views, options_.box_m * 0.5,
            [this](const std::string& line) { say(line); }) {}

Generator::~Generator() {
  detach();
  if (query_ != nullptr) stage_.world().release(query_);
}

void Generator::say(const std::string& line) const {
  messages_.say(line, now_ns());
}

Error Generator::run() {
  began_ = now_ns();
  if (Error error = check_outputs(); !error.ok()) return error;
  Error error = prepare();
  if (error.ok()) error = loop();
  // After it, files cannot be read.
  if (!error.ok() && (now_.quit || signals_.take().end)) error = {};
  if (display_ == nullptr) return error;
  if (Error written = write_statistics(); error.ok()) error = std::move(written);
  if (Error written = write_picture(); error.ok()) error = std::move(written);
  return error;
}

Error Generator::check_outputs() const {
  std::vector<app::NamedFile> outputs;
  if (!options_.stats.empty() && options_.stats != "-") outputs.push_back({"--stats", options_.stats});
  if (!options_.picture.empty()) outputs.push_back({"--picture", options_.picture});
  if (Error error = app::check_outputs_apart(outputs, files_read(options_.world, options_.scene));
      !error.ok())
    return error;
  for (const app::NamedFile& output : outputs) {
    if (Error error = app::check_writable(output.path); !error.ok()) return error;
  }
  return {};
}

Error Generator::prepare() {
  if (Error error = link_.open(options_.listen_address, options_.host_address); !error.ok()) return error;
  app::StageNeeds needs;
  needs.views = static_cast<std::uint32_t>(options_.views.count);
  needs.queries = 2;
  needs.query_patches = kQueryPatches;
  needs.query_bytes = kQueryBytes;
  needs.query_tiles = kQueryTiles;
  needs.overlay_bytes = Boxes::kBytes;
  if (Error error = stage_.load(options_.world, options_.scene, needs); !error.ok()) return error;
  if (Error error = earth_.open(stage_.world(), options_.anchor); !error.ok())
    return options_.world + ": " + error.text();
  if (Error error = ground_.open(stage_.world()); !error.ok()) return error;
  if (const Status status = stage_.world().take_query(query_); !status.ok()) return {options_.world, status};
  view_ = stage_view(options_.scene, stage_.world().info());
  if (options_.scene.generate_ms < 0) view_.work_ms = kGenerateMs;
  // Without a screen the picture is there when the GPU is done.
  view_.wait = options_.output == app::ScreenArguments::Output::headless;
  view_.draw_over = draw_over;
  view_.user = this;
  return open_screen(
      options_, {options_.scene.width, options_.scene.height}, "karst-ig", console_,
      [this](const std::string& line) { say(line); }, seat_, display_);
}

// --- the loop

std::int64_t Generator::interval_ns() const {
  const std::int64_t refresh = display_->refresh_ns();
  return refresh > 0 ? refresh : static_cast<std::int64_t>(1e9 / options_.rate_hz);
}

// Where a screen shows nothing, the host is told and answered nevertheless.
bool Generator::is_due(std::int64_t now) const {
  return now >= (display_->ready() ? next_ : std::max(next_, last_ + 2 * interval_ns()));
}

Error Generator::loop() {
  while (!now_.quit) {
    wait();
    take_signals();
    const Display::Changes changes = display_->dispatch();
    now_.quit = now_.quit || changes.quit;
    if (changes.rebuild) detach();
    if (!stage_.attached() && display_->ready()) {
      if (Error error = attach(); !error.ok()) return error;
      if (series_.frames == 0) {
        if (Error error = warm_up(); !error.ok()) return error;
      }
    }
    if (is_due(now_ns())) {
      if (Error error = frame(); !error.ok()) return error;
    }
    const double seconds = ms_between(began_, now_ns()) / 1000;
    if (options_.seconds > 0 && seconds > options_.seconds) return {};
    if (options_.wait_s >= 0 && !now_.has_drawn && seconds > options_.wait_s)
      return "no display came within --wait";
  }
  return {};
}

// Until something happens or a frame is due.
void Generator::wait() const {
  std::array<pollfd, Display::kMostFds + 1> fds{};
  std::size_t count = display_->poll_fds(std::span(fds).first(Display::kMostFds));
  fds[count++] = {signals_.fd(), POLLIN, 0};
  std::int64_t until = display_->ready() ? next_ : std::max(next_, last_ + 2 * interval_ns());
  until = std::min(until, display_->deadline_ns());
  const std::int64_t left = std::max<std::int64_t>(0, until - now_ns());
  const timespec timeout{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
  ppoll(fds.data(), count, &timeout, nullptr);
}

// A flood of SIGHUP has no more written than what is asked for once in kStatistics_ns; the last is written.
void Generator::take_signals() {
  const app::Signals::Taken taken = signals_.take();
  now_.quit = now_.quit || taken.end;
  asked_statistics_.wanted = asked_statistics_.wanted || taken.statistics;
  if (!asked_statistics_.wanted || now_.quit || now_ns() < asked_statistics_.at) return;
  if (const Error error = write_statistics(); !error.ok()) say(error.text());
  asked_statistics_.wanted = false;
  asked_statistics_.at = now_ns() + kStatistics_ns;
}

// When the next is due, and whether this one is late. Screens pace frames themselves, and a tenth early
// leaves room for their timers; without one, frames keep to a grid.
void Generator::begin_frame_times(std::int64_t start) {
  const std::int64_t interval = interval_ns();
  now_.late = last_ != 0 && start - last_ > interval + interval / 2;
  if (now_.late) {
    const auto missed = static_cast<std::uint64_t>((start - last_ + interval / 2) / interval) - 1;
    series_.missed += missed;
    series_.most_missed = std::max(series_.most_missed, missed);
  }
  if (display_->refresh_ns() > 0) {
    next_ = start + interval - interval / 10;
  } else {
    next_ = next_ == 0 ? start + interval : next_ + interval;
    if (next_ <= start) next_ = start + interval - (start - next_) % interval;
  }
  last_ = start;
}

Error Generator::frame() {
  const std::int64_t start = now_ns();
  begin_frame_times(start);
  display_->begin_frame(start);
  link_.read([&](std::span<const std::byte> datagram, std::int64_t arrived) {
    host_.take(datagram, earth_, arrived);
  });
  host_.advance(earth_, *query_, start);
  const std::uint64_t answers = host_.counts().answers;
  const std::int64_t before = now_ns();
  const std::span<const std::byte> message = host_.message(earth_, *query_, start, now_.late, now_.paging);
  if (host_.counts().answers != answers) series_.answer_ms.add(ms_between(before, now_ns()));
  const bool sent = link_.send(message);
  if (!sent && !now_.unsent)
    say("--host: datagrams cannot be sent: " + std::string(std::strerror(link_.reason())));
  now_.unsent = !sent;
  const std::int64_t arrived = host_.take_arrival();
  if (arrived != 0) series_.wait_ms.add(ms_between(arrived, start));
  ++series_.frames;
  return stage_.attached() && display_->ready() ? draw(start, arrived) : Error();
}

// --- the picture

Error Generator::attach() {
  Display::Size size = display_->size();
  if (size.width == 0) size = {options_.scene.width, options_.scene.height};
  if (Error error = display_->make_current(); !error.ok()) return error;
  if (Error error = stage_.attach(*display_, size.width, size.height); !error.ok()) return error;
  const GlLoader loader{
      [](void* user, const char* name) { return static_cast<const Display*>(user)->gl_function(name); },
      display_.get()};
  if (const Status status = boxes_.create(app::counting_loader(loader)); !status.ok())
    return {display_->name(), status};
  now_.lost = false;
  context_.attach(*display_);
  return {};
}

void Generator::detach() {
  if (!stage_.attached()) return;
  if (now_.lost) {
    boxes_.forget();
  } else {
    boxes_.destroy();
  }
  stage_.detach(now_.lost);
}

void Generator::draw_over(void* user, const ViewState& view, bool two_ranges) {
  auto& own = *static_cast<Generator*>(user);
  const auto number = static_cast<std::uint32_t>(&view - own.host_.views().states().data());
  own.boxes_.draw(own.host_.entities(), own.host_.half_box_m(), view, own.stage_.renderer().air(number),
                  two_ranges);
}

// Shaders, tiles and shadow maps of what is seen at first; nothing is shown.
Error Generator::warm_up() {
  const std::int64_t until = now_ns() + kWarm_ns;
  app::FrameRecord record;
  for (int frame = 0; frame < kWarmFrames || !record.result.complete; ++frame) {
    take_signals();
    if (now_.quit || now_ns() > until) return {};
    if (Error error = draw_views(now_ns(), record); !error.ok()) return error;
    if (record.costs.vertices_lost) return {};
  }
  return {};
}

Error Generator::draw_views(std::int64_t start, app::FrameRecord& record) {
  const Picture picture{stage_.width(), stage_.height(), display_->quarter_turns(), stage_.reversed_depth(),
                        options_.scene.fov_y_deg};
  Views& views = host_.views();
  views.advance(host_.entities(), stage_.world().info(), ground_, picture, view_.view);
  app::StageView view = view_;
  view.views = views.states();
  view.parts = views.parts();
  const Vec3 eye = view.views[0].eye;
  turn_sun(stage_.world().axes_at(eye), stage_.world().info(), view);
  host_.air().light(earth_, {eye.x, eye.y, eye.z}, start, view.sun);
  return stage_.draw(view, record);
}

Error Generator::draw(std::int64_t start, std::int64_t arrived) {
  app::FrameRecord record;
  Error error = draw_views(start, record);
  const bool unread = (record.result.limits & kLimitFile) != 0;
  if (unread && app::FileSource::is_stopped()) return error;
  if (unread && !now_.unread)
    say(options_.world + ": heights cannot be read; drawn coarser, and tried again");
  if (!unread && now_.unread) say(options_.world + ": heights can be read again");
  now_.unread = unread;
  if (!error.ok()) return error;
  now_.paging = !record.result.complete;
  if (record.costs.vertices_lost) {
    detach();
    return {};
  }
  stage_.target().present();
  now_.has_drawn = true;
  const std::int64_t drawn = now_ns();
  series_.draw_ms.add(ms_between(start, drawn));
  if (arrived != 0) series_.latency_ms.add(ms_between(arrived, drawn));
  if (context_.is_lost()) {
    now_.lost = true;
    display_->context_lost();
    return {};
  }
  return display_->present();
}

// --- what is written

Error Generator::write_statistics() const {
  if (options_.stats.empty()) return {};
  app::JsonWriter json;
  json.begin_object();
  json.field("frames", series_.frames);
  json.key("size").begin_array().value(stage_.width()).value(stage_.height()).end_array();
  json.key("renderer");
  if (stage_.attached()) {
    json.value(device_info(stage_.renderer()).renderer);
  } else {
    json.null();
  }
  json.field("display", std::string_view(display_->name()));
  json.field("interval_ms", static_cast<double>(interval_ns()) * 1e-6);
  json.field("missed", series_.missed).field("most_missed_in_a_row", series_.most_missed);
  write_series(json, "latency_ms", series_.latency_ms);
  write_series(json, "wait_ms", series_.wait_ms);
  write_series(json, "draw_ms", series_.draw_ms);
  write_series(json, "answer_ms", series_.answer_ms);
  write_series(json, "screen_ms", display_->times().latency_ms());
  const cigi::ReadCounts& read = host_.read_counts();
  json.key("host").begin_object();
  json.field("version", std::to_string(host_.version().major) + "." + std::to_string(host_.version().minor));
  json.field("frame", std::uint64_t{host_.host_frame()});
  json.field("messages", read.messages).field("packets", read.packets).field("unknown", read.unknown);
  json.field("malformed", read.malformed).field("cut", read.cut).field("rejected", read.rejected);
  json.field("foreign", link_.counts().foreign);
  json.field("sent", link_.counts().sent).field("unsent", link_.counts().unsent);
  json.field("requests", host_.counts().requests).field("answers", host_.counts().answers);
  json.field("waiting", std::uint64_t{host_.waiting()});
  json.field("entities", std::uint64_t{host_.entities().all().size()}).end_object();
  json.field("descriptors", app::open_descriptors()).field("gl_objects", app::gl_objects_alive());
  json.key("bytes").begin_object();
  json.field("cpu_budget", stage_.cpu_bytes());
  json.field("gpu_budget", stage_.gpu_bytes()).field("gpu_used", stage_.gpu_used()).end_object();
  json.end_object();
  const std::string text = json.text();
  if (options_.stats == "-") {
    std::fputs(text.c_str(), stdout);
    return app::flush_output();
  }
  return app::write_file_atomic(options_.stats, std::as_bytes(std::span(text)));
}

Error Generator::write_picture() {
  if (options_.picture.empty()) return {};
  if (!stage_.attached() || !now_.has_drawn) return "--picture: no frame was drawn";
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(stage_.width()) *
                                 static_cast<std::size_t>(stage_.height()) * 4);
  if (const Status status = stage_.target().read_colour(rgba); !status.ok()) return {"--picture", status};
  std::vector<std::byte> png;
  if (Error error = app::encode_png(rgba, stage_.width(), stage_.height(), png); !error.ok())
    return options_.picture + ": " + error.text();
  return app::write_file_atomic(options_.picture, png);
}

}  // namespace karst::ig
