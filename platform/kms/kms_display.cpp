// SPDX-License-Identifier: MIT
#include "platform/kms/kms_display.h"

#include <drm_fourcc.h>
#include <gbm.h>
#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "platform/base/clock.h"
#include "platform/kms/gbm_context.h"
#include "platform/kms/kms_card.h"
#include "platform/kms/kms_pipe.h"
#include "platform/kms/swapchain.h"
#include "platform/wakeups.h"

namespace karst {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr int kFlipWait_ms = 100;
constexpr std::int64_t kNoCardRetry = 500 * kMillisecond;
constexpr std::int64_t kDarkRetry = 2000 * kMillisecond;
constexpr std::int64_t kMasterRetry = 100 * kMillisecond;
constexpr std::int64_t kBusyRetry = 20 * kMillisecond;

struct GbmFree {
  void operator()(gbm_device* device) const { gbm_device_destroy(device); }
};

std::uint32_t drm_format(ColourFormat format) {
  return format == ColourFormat::rgb565 ? DRM_FORMAT_RGB565 : DRM_FORMAT_XRGB8888;
}

bool not_master(int error) {
  return error == -EACCES || error == -EPERM;
}

class KmsDisplay final : public Display {
 public:
  KmsDisplay(KmsOptions options, Seat& seat, ConsoleState& console, Log log, const EglApi& egl)
      : options_(std::move(options)),
        seat_(seat),
        console_(console),
        log_(std::move(log)),
        egl_(egl),
        context_(egl),
        hotplug_(log_) {}

  ~KmsDisplay() override {
    wait_for_flip();
    if (card_.is_open()) restore_crtc(console_, card_.fd(), log_);
    close_card();
  }

  // The first look. Empty on success, and where there is no screen yet.
  std::string start() {
    seat_active_ = seat_.active();
    std::string fatal;
    find_card(fatal);
    return fatal;
  }

  std::string make_current() override {
    return context_.is_open() ? context_.make_current() : std::string("there is no display yet");
  }
  Size size() const override { return state_ == State::no_card ? Size{} : framebuffer_size(); }
  GlFunction gl_function(const char* name) const override { return egl_.get_proc_address(name); }
  const std::string& name() const override { return name_; }
  int quarter_turns() const override { return context_turns_; }
  std::int64_t refresh_ns() const override {
    const double hz = refresh_hz(mode_);
    return hz > 0 ? static_cast<std::int64_t>(1e9 / hz) : 0;
  }
  void context_lost() override { context_lost_ = true; }

  bool ready() const override {
    return state_ == State::on && seat_active_ && !context_lost_ && now_ns() >= busy_until_ &&
           (pending_ == Swapchain::kNone || (options_.buffers > 2 && waiting_ == Swapchain::kNone)) &&
           swapchain_.has_free();
  }

  std::size_t poll_fds(std::span<pollfd> out) const override {
    std::size_t count = 0;
    for (const int fd : {card_.fd(), seat_.fd(), hotplug_.fd(), resume_.fd()}) {
      if (fd >= 0 && count < out.size()) out[count++] = {fd, POLLIN, 0};
    }
    return count;
  }

  std::int64_t deadline_ns() const override {
    if (changes_.rebuild || changes_.redraw || context_lost_) return 0;
    std::int64_t at = retry_at_;
    if (pending_ != Swapchain::kNone) at = std::min(at, flip_deadline_);
    if (state_ == State::on && busy_until_ > 0) at = std::min(at, busy_until_);
    return at;
  }

  Changes dispatch() override;
  std::string present() override;

 private:
  enum class State { no_card, dark, no_master, on };

  void follow_seat();
  void handle_card_events();
  void handle_time(bool look);
  void try_master();
  void look_at_connectors();
  void find_card(std::string& fatal);
  bool open_card();
  void close_card();
  bool open_context();
  std::string configure();
  bool try_attempts();
  std::string set_up(const KmsAttempt& attempt, int plane_turns);
  std::string choose(std::size_t& mode);
  bool wait_for_flip();
  void flip_done();
  void show_first(int slot);
  void show_again();
  void mode_is_set();
  void show_next(int slot);
  void queue_flip(int slot);
  void refused(int slot, int error, const std::string& what);
  void lose_flip();
  void forget_screen();
  void rest(State state, std::int64_t retry);
  void say(const std::string& line);  // but not the same again and again
  Size framebuffer_size() const {
    return {static_cast<int>(swapchain_.width()), static_cast<int>(swapchain_.height())};
  }
  KmsPicture picture(int slot) const {
    return {swapchain_.framebuffer(slot), swapchain_.width(), swapchain_.height(), plane_turns_};
  }
  const KmsAttempt& attempt() const { return plan_[attempt_]; }

  KmsOptions options_;
  Seat& seat_;
  ConsoleState& console_;
  Log log_;
  EglApi egl_;
  std::string name_ = "KMS";
  std::string last_said_;
  std::vector<std::string> last_reasons_;

  KmsCard card_;
  KmsConnector connector_;
  std::unique_ptr<gbm_device, GbmFree> gbm_;
  GbmContext context_;   // on gbm_
  Swapchain swapchain_;  // on gbm_, under context_'s surface
  KmsPipe pipe_;
  HotplugMonitor hotplug_;
  ResumeTimer resume_;

  State state_ = State::no_card;
  bool seat_active_ = true;
  bool context_lost_ = false;
  bool mode_set_ = false;  // the screen shows the swapchain's pictures
  bool told_ = false;      // what is shown was said
  Changes changes_;        // not yet told
  std::int64_t retry_at_ = 0;
  std::int64_t busy_until_ = 0;
  std::int64_t flip_deadline_ = 0;
  std::int64_t possible_since_ = 0;  // when the screen could be used again; 0: it is in use

  std::vector<KmsAttempt> plan_;             // for these modes
  std::vector<drmModeModeInfo> plan_modes_;  // the connector's when it was configured
  drmModeModeInfo wanted_mode_{};
  std::size_t attempt_ = 0;
  drmModeModeInfo mode_{};
  int plane_turns_ = 0;
  int context_turns_ = 0;

  int on_screen_ = Swapchain::kNone;
  int pending_ = Swapchain::kNone;  // queued to the kernel
  int waiting_ = Swapchain::kNone;  // drawn, behind pending_; with three buffers
};

void KmsDisplay::say(const std::string& line) {
  if (line == last_said_) return;
  last_said_ = line;
  log_(line);
}

void KmsDisplay::rest(State state, std::int64_t retry) {
  state_ = state;
  retry_at_ = retry == kNever ? kNever : now_ns() + retry;
}

Display::Changes KmsDisplay::dispatch() {
  follow_seat();
  bool look = hotplug_.take();
  if (resume_.take() && state_ == State::on) {
    mode_set_ = false;  // what the driver makes of the screen while asleep is its own affair
    changes_.redraw = true;
    look = true;
  }
  handle_card_events();
  if (context_lost_) {
    context_lost_ = false;
    log_("the GL context is lost; making everything anew");
    forget_screen();
    if (!open_context() || !try_attempts()) {
      close_card();
      rest(State::no_card, 0);
    } else {
      changes_.rebuild = true;
    }
  }
  if (look || now_ns() >= retry_at_) handle_time(look);
  if (state_ == State::on && busy_until_ > 0 && now_ns() >= busy_until_) {
    busy_until_ = 0;
    changes_.redraw = true;
  }
  const Changes result = state_ == State::on && seat_active_ ? changes_ : Changes{};
  if (state_ == State::on && seat_active_) changes_ = {};
  return result;
}

void KmsDisplay::follow_seat() {
  seat_.dispatch();
  if (seat_.active() == seat_active_) return;
  seat_active_ = seat_.active();
  if (!seat_active_) {
    log_("the terminal is switched away");
    wait_for_flip();
    if (card_.is_open() && seat_.sets_master()) drmDropMaster(card_.fd());
    seat_.released();
    mode_set_ = false;
    return;
  }
  log_("the terminal is back");
  possible_since_ = now_ns();
  // Other programs may have changed anything: becoming master again and looking at the monitors come first.
  if (state_ == State::on || state_ == State::no_master) rest(State::no_master, 0);
  if (state_ == State::dark || state_ == State::no_card) retry_at_ = 0;
}

void KmsDisplay::handle_card_events() {
  if (!card_.is_open()) return;
  pollfd fd{card_.fd(), POLLIN, 0};
  if (poll(&fd, 1, 0) > 0) {
    drmEventContext handlers{};
    handlers.version = 2;
    handlers.page_flip_handler = [](int, unsigned, unsigned, unsigned, void* self) {
      static_cast<KmsDisplay*>(self)->flip_done();
    };
    errno = 0;
    if ((fd.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0 || drmHandleEvent(card_.fd(), &handlers) != 0) {
      say(errno_text(card_.path() + ": the card is gone", errno != 0 ? errno : ENODEV));
      close_card();
      rest(State::no_card, kMasterRetry);
      return;
    }
  }
  if (pending_ != Swapchain::kNone && now_ns() >= flip_deadline_) lose_flip();
}

// Nothing came for a flip: the driver has lost it, or the screen is off. The mode is set anew, which needs no
// event.
void KmsDisplay::lose_flip() {
  times_.flip_lost();
  say("no word of a flip for 100 ms; setting the mode again");
  swapchain_.release(std::exchange(waiting_, Swapchain::kNone));
  swapchain_.release(std::exchange(pending_, Swapchain::kNone));
  mode_set_ = false;
  changes_.redraw = true;
}

void KmsDisplay::handle_time(bool look) {
  retry_at_ = hotplug_.fd() < 0 && state_ == State::on ? now_ns() + kDarkRetry : kNever;
  if (!seat_active_) return;
  std::string fatal;
  switch (state_) {
    case State::no_card:
      find_card(fatal);
      if (!fatal.empty()) say(fatal);
      break;
    case State::no_master:
      try_master();
      break;
    case State::dark:
      look_at_connectors();
      break;
    case State::on:
      if (look || hotplug_.fd() < 0) look_at_connectors();
      break;
  }
}

void KmsDisplay::try_master() {
  int error = 0;
  if (seat_.sets_master()) {
    error = drmSetMaster(card_.fd());
  } else if (drmIsMaster(card_.fd()) != 1) {
    error = -EACCES;
  }
  if (error == 0) {
    log_("this program has the screen again");
    possible_since_ = now_ns();
    look_at_connectors();
  } else if (error == -ENODEV) {
    say(errno_text(card_.path() + ": the card is gone", error));
    close_card();
    rest(State::no_card, kMasterRetry);
  } else {
    rest(State::no_master, kMasterRetry);
  }
}

// The card is open: is its monitor there, and the same?
void KmsDisplay::look_at_connectors() {
  std::vector<KmsConnector> connectors;
  if (const std::string error = card_.read_connectors(connectors); !error.empty()) {
    const bool gone = errno == ENODEV;
    say(card_.path() + ": " + error);
    if (gone) close_card();
    rest(card_.is_open() ? State::dark : State::no_card, kNoCardRetry);
    return;
  }
  const auto usable = [&](const KmsConnector& c) {
    return c.connected && !c.modes.empty() &&
           (options_.connector.empty() || options_.mode_fallback || c.name == options_.connector);
  };
  auto found = std::find_if(connectors.begin(), connectors.end(),
                            [&](const KmsConnector& c) { return c.id == connector_.id && usable(c); });
  if (found == connectors.end()) found = std::find_if(connectors.begin(), connectors.end(), usable);
  if (found == connectors.end()) {
    if (state_ == State::on || state_ == State::no_master) log_(connector_.name + ": the monitor is gone");
    mode_set_ = false;
    rest(State::dark, kDarkRetry);
    // Another card may have one.
    KmsCard other;
    KmsConnector there;
    std::vector<std::string> reasons;
    std::string ignored;
    if (options_.card.empty() && card_paths(ignored).size() > 1 &&
        find_output(seat_, {}, options_.mode_fallback ? std::string() : options_.connector, other, there,
                    reasons) &&
        other.path() != card_.path()) {
      other.close();
      close_card();
      rest(State::no_card, 0);
    }
    return;
  }
  const bool was_on = state_ == State::on;
  const bool same_connector = found->id == connector_.id;
  connector_ = *found;
  std::size_t mode = kNoMode;
  if (const std::string error = choose(mode); !error.empty()) {
    say(error);
    mode_set_ = false;
    rest(State::dark, kDarkRetry);
    return;
  }
  if (!was_on && possible_since_ == 0) possible_since_ = now_ns();
  // What is shown may be a lower mode, because the driver refused this one.
  const bool same = same_connector && !plan_.empty() && same_mode(connector_.modes[mode], wanted_mode_) &&
                    swapchain_.surface() != nullptr;
  if (same) {
    if (state_ == State::dark) log_(connector_.name + ": the monitor is back");
    rest(State::on, hotplug_.fd() < 0 ? kDarkRetry : kNever);
    if (!was_on) show_again();
    return;
  }
  if (const std::string error = configure(); !error.empty()) {
    say(error);
    rest(State::dark, kDarkRetry);
  }
}

void KmsDisplay::find_card(std::string& fatal) {
  std::vector<std::string> reasons;
  const bool any = find_output(seat_, options_.card, options_.connector, card_, connector_, reasons);
  for (const std::string& reason : reasons) {
    if (any || reasons != last_reasons_) log_(reason);
  }
  last_reasons_ = reasons;
  if (!any && options_.mode_fallback && !options_.connector.empty() &&
      find_output(seat_, options_.card, {}, card_, connector_, reasons)) {
    log_(options_.connector + " has no monitor; taking " + connector_.name);
  }
  if (!card_.is_open()) {
    say("waiting for a monitor");
    rest(State::no_card, kNoCardRetry);
    return;
  }
  std::size_t mode = kNoMode;
  fatal = choose(mode);
  if (!fatal.empty()) {
    close_card();
    rest(State::no_card, kNoCardRetry);
    return;
  }
  if (possible_since_ == 0) possible_since_ = now_ns();
  if (!open_card()) {
    close_card();
    rest(State::no_card, kNoCardRetry);
  }
}

bool KmsDisplay::open_card() {
  if (seat_.sets_master() && drmIsMaster(card_.fd()) == 0) drmSetMaster(card_.fd());
  gbm_.reset(gbm_create_device(card_.fd()));
  if (gbm_ == nullptr) {
    say(card_.path() + ": " + errno_text("gbm_create_device", errno != 0 ? errno : ENODEV));
    return false;
  }
  if (!open_context()) return false;
  const std::string error = configure();
  if (!error.empty()) say(error);
  return error.empty();
}

bool KmsDisplay::open_context() {
  const std::string error = context_.open(gbm_.get(), drm_format(options_.format));
  if (!error.empty()) say(card_.path() + ": " + error);
  changes_.rebuild = true;
  return error.empty();
}

void KmsDisplay::close_card() {
  forget_screen();
  context_.close();
  pipe_.close();
  gbm_.reset();
  card_.close();
  plan_.clear();
  connector_ = {};
  changes_.rebuild = true;
}

// Buffers and what they are on; the context stays.
void KmsDisplay::forget_screen() {
  on_screen_ = pending_ = waiting_ = Swapchain::kNone;
  mode_set_ = false;
  context_.drop_surface();
  swapchain_.destroy();
}

std::string KmsDisplay::choose(std::size_t& mode) {
  mode = choose_mode(connector_.modes, options_.mode);
  if (mode != kNoMode) return {};
  std::string names;
  for (const drmModeModeInfo& m : connector_.modes) {
    if (names.size() < 200) names.append(" ").append(mode_text(m));
  }
  if (options_.mode_fallback) {
    say(connector_.name + ": the wanted mode is not there; taking the preferred one");
    mode = choose_mode(connector_.modes, {});
    if (mode != kNoMode) return {};
  }
  return connector_.name + ": --mode: no such mode; there are" + names;
}

std::string KmsDisplay::configure() {
  wait_for_flip();
  std::size_t mode = kNoMode;
  if (std::string error = choose(mode); !error.empty()) return error;
  forget_screen();
  const std::uint32_t format = drm_format(options_.format);
  std::string error = pipe_.open(card_, connector_, options_.atomic, format, console_);
  if (!error.empty() && options_.atomic && options_.legacy) {
    log_(card_.path() + ": " + error + "; using the legacy calls");
    error = pipe_.open(card_, connector_, false, format, console_);
  }
  if (!error.empty()) return card_.path() + ": " + error;
  if (!console_.crtc_taken.load()) {
    log_(card_.path() + ": what the screen shows cannot be read (drmModeGetCrtc), so it is not given back");
  }
  if (!card_.lacks().empty()) say(card_.path() + ": " + card_.lacks());
  AttemptLimits limits;
  limits.atomic = options_.atomic && pipe_.is_atomic();
  limits.legacy = options_.legacy;
  limits.modifiers = options_.modifiers && card_.modifiers() && !pipe_.modifiers().empty();
  limits.lower_modes = options_.mode.kind != ModeRequest::Kind::exact || options_.mode_fallback;
  plan_modes_ = connector_.modes;
  wanted_mode_ = plan_modes_[mode];
  plan_ = plan_attempts(plan_modes_, mode, limits);
  attempt_ = 0;
  if (plan_.empty()) return card_.path() + ": the driver has no atomic calls, and the legacy ones are off";
  if (!try_attempts()) return connector_.name + ": no way to show a picture works";
  rest(State::on, hotplug_.fd() < 0 ? kDarkRetry : kNever);
  return {};
}

// From attempt_ on; the first that the driver takes.
bool KmsDisplay::try_attempts() {
  const Size before = framebuffer_size();
  for (; attempt_ < plan_.size(); ++attempt_) {
    const int turns = options_.quarter_turns & 3;
    std::string error;
    if (turns != 0 && attempt().atomic && pipe_.can_turn(turns)) {
      error = set_up(attempt(), turns);
      if (error.empty()) break;
      log_(connector_.name + " " + attempt_text(attempt(), plan_modes_) +
           ": the plane cannot turn it: " + error);
    }
    error = set_up(attempt(), 0);
    if (error.empty()) break;
    log_(connector_.name + " " + attempt_text(attempt(), plan_modes_) + ": " + error +
         (attempt_ + 1 < plan_.size() ? "; trying the next way" : ""));
  }
  if (attempt_ == plan_.size()) {
    forget_screen();
    return false;
  }
  if (!(before == framebuffer_size())) changes_.rebuild = true;
  changes_.redraw = true;
  told_ = false;
  return true;
}

std::string KmsDisplay::set_up(const KmsAttempt& way, int plane_turns) {
  forget_screen();
  mode_ = plan_modes_[way.mode];
  plane_turns_ = plane_turns;
  context_turns_ = (options_.quarter_turns - plane_turns) & 3;
  std::uint32_t width = mode_.hdisplay;
  std::uint32_t height = mode_.vdisplay;
  if ((plane_turns & 1) != 0) std::swap(width, height);
  const std::vector<std::uint64_t> none;
  std::string error = swapchain_.create(gbm_.get(), card_.fd(), width, height, drm_format(options_.format),
                                        way.modifiers ? pipe_.modifiers() : none);
  if (error.empty() && way.atomic) {
    KmsPicture probe{0, width, height, plane_turns};
    error = swapchain_.make_probe(probe.framebuffer);
    if (error.empty()) {
      const int refused = pipe_.test(mode_, probe);
      if (not_master(refused)) {
        say(connector_.name + ": " + errno_text("TEST_ONLY commit", refused) + "; the first frame will tell");
      } else if (refused != 0) {
        error = errno_text("TEST_ONLY commit", refused);
      }
    }
    swapchain_.drop_probe();
  }
  if (error.empty()) error = context_.set_surface(swapchain_.surface());
  return error;
}

void KmsDisplay::flip_done() {
  if (pending_ == Swapchain::kNone) return;
  swapchain_.release(std::exchange(on_screen_, std::exchange(pending_, Swapchain::kNone)));
  times_.shown(now_ns(), refresh_ns());
  if (waiting_ != Swapchain::kNone) queue_flip(std::exchange(waiting_, Swapchain::kNone));
}

// Whether none is under way in the end. Gives up after 100 ms.
bool KmsDisplay::wait_for_flip() {
  while (pending_ != Swapchain::kNone) {
    const std::int64_t left = flip_deadline_ - now_ns();
    pollfd fd{card_.fd(), POLLIN, 0};
    if (left > 0) poll(&fd, 1, static_cast<int>(left / kMillisecond) + 1);
    handle_card_events();  // which ends the waiting at the deadline
    if (!card_.is_open()) return false;
  }
  return true;
}

std::string KmsDisplay::present() {
  if (state_ != State::on || !seat_active_ || context_lost_) return {};
  if (options_.buffers == 2 && !wait_for_flip()) return {};
  if (waiting_ != Swapchain::kNone && !wait_for_flip()) return {};
  std::string error;
  switch (context_.swap(error)) {
    case GbmContext::Swapped::done:
      break;
    case GbmContext::Swapped::context_lost:
      context_lost_ = true;
      return {};
    case GbmContext::Swapped::failed:
      say(card_.path() + ": " + error);
      close_card();
      rest(State::no_card, kNoCardRetry);
      return {};
  }
  int slot = Swapchain::kNone;
  error = swapchain_.take_front(slot);
  if (!error.empty()) {
    say(card_.path() + ": " + error);
    busy_until_ = now_ns() + kMasterRetry;
    return {};
  }
  times_.queued();
  mode_set_ ? show_next(slot) : show_first(slot);
  return {};
}

void KmsDisplay::show_first(int slot) {
  wait_for_flip();
  if (state_ != State::on) return;
  const int error = pipe_.set_mode(mode_, picture(slot), attempt().atomic);
  if (error != 0) {
    refused(slot, error, attempt().atomic ? "setting the mode" : "drmModeSetCrtc");
    return;
  }
  swapchain_.release(std::exchange(on_screen_, slot));
  times_.shown(now_ns(), refresh_ns());
  mode_is_set();
}

void KmsDisplay::mode_is_set() {
  mode_set_ = true;
  times_.mode_set();
  if (possible_since_ != 0) {
    const std::int64_t now = now_ns();
    const std::int64_t since = std::exchange(possible_since_, 0);
    times_.recovered(since, now);
    if (told_) log_("the picture is back after " + std::to_string((now - since) / kMillisecond) + " ms");
  }
  last_said_.clear();
  if (told_) return;
  told_ = true;
  const std::string how = attempt_text(attempt(), plan_modes_);
  name_ = "KMS " + connector_.name + " " + how;
  log_("showing on " + card_.path() + " (" + card_.driver() + ") " + connector_.name + " " + how + ", " +
       std::to_string(options_.buffers) + " buffers" +
       (plane_turns_ != 0     ? ", turned by the plane"
        : context_turns_ != 0 ? ", turned by the projection"
                              : ""));
}

// The screen can be used again and the last picture is still in its buffer: nothing needs to be drawn.
void KmsDisplay::show_again() {
  mode_set_ = false;
  wait_for_flip();
  if (!card_.is_open()) return;
  const int error =
      on_screen_ == Swapchain::kNone ? -ENOENT : pipe_.set_mode(mode_, picture(on_screen_), attempt().atomic);
  if (error == 0) {
    mode_is_set();
  } else if (not_master(error)) {
    rest(State::no_master, kMasterRetry);
  } else {
    changes_.redraw = true;  // and whatever else it takes
  }
}

void KmsDisplay::show_next(int slot) {
  if (pending_ != Swapchain::kNone) {
    waiting_ = slot;
    return;
  }
  queue_flip(slot);
}

void KmsDisplay::queue_flip(int slot) {
  const int error = pipe_.flip(picture(slot), attempt().atomic, this);
  if (error != 0) {
    refused(slot, error, "page flip");
    return;
  }
  pending_ = slot;
  flip_deadline_ = now_ns() + kFlipWait_ms * kMillisecond;
}

// The driver did not take a frame: what follows from its reason.
void KmsDisplay::refused(int slot, int error, const std::string& what) {
  swapchain_.release(slot);
  say(connector_.name + ": " + errno_text(what, error));
  if (not_master(error)) {
    mode_set_ = false;
    rest(State::no_master, kMasterRetry);
  } else if (error == -ENODEV || error == -ENXIO) {
    close_card();
    rest(State::no_card, kMasterRetry);
  } else if (error == -EBUSY || error == -EINTR || error == -EAGAIN || error == -ENOMEM) {
    busy_until_ = now_ns() + kBusyRetry;
  } else if (mode_set_) {
    mode_set_ = false;  // what flips cannot do, a mode may
    changes_.redraw = true;
  } else if (++attempt_ < plan_.size()) {
    log_("trying " + attempt_text(attempt(), plan_modes_));
    if (!try_attempts()) rest(State::dark, kDarkRetry);
  } else {
    log_(connector_.name + ": no way to show a picture works; trying again");
    attempt_ = 0;
    plan_.clear();
    rest(State::dark, kDarkRetry);
  }
}

}  // namespace

std::unique_ptr<Display> open_kms_display(const KmsOptions& options, Seat& seat, ConsoleState& console,
                                          const Log& log, std::string& error, const EglApi& egl) {
  auto display = std::make_unique<KmsDisplay>(options, seat, console, log, egl);
  error = display->start();
  if (!error.empty()) return nullptr;
  return display;
}

}  // namespace karst
