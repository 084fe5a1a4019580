// SPDX-License-Identifier: MIT
#include "platform/kms/kms_display.h"

#include <xf86drm.h>

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include "platform/base/clock.h"
#include "platform/kms/card/kms_card.h"
#include "platform/kms/kms_choice.h"
#include "platform/kms/kms_log.h"
#include "platform/kms/kms_scanout.h"
#include "platform/wakeups.h"

namespace karst {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr int kFlipWait_ms = 100;
constexpr std::int64_t kNoCardRetry = 500 * kMillisecond;
constexpr std::int64_t kDarkRetry = 2000 * kMillisecond;
constexpr std::int64_t kMasterRetry = 100 * kMillisecond;
constexpr std::int64_t kBusyRetry = 20 * kMillisecond;

class KmsDisplay final : public Display {
 public:
  KmsDisplay(KmsOptions options, Seat& seat, ConsoleState& console, LogLine log, const EglApi& egl)
      : options_(std::move(options)),
        seat_(seat),
        console_(console),
        log_(std::move(log)),
        choice_(options_, seat, log_),
        scanout_(options_, card_, connector_, console, log_, egl),
        hotplug_(log_.log()) {}

  ~KmsDisplay() override {
    wait_for_flip();
    if (card_.is_open()) restore_crtc(console_, card_.fd(), log_.log());
    close_card();
  }

  // The first look. No error where there is no screen yet.
  Error start() {
    seat_active_ = seat_.active();
    return find_card();
  }

  Error make_current() override {
    if (!scanout_.context().is_open()) return "there is no display yet";
    return scanout_.context().make_current();
  }
  Size size() const override { return state_ == State::no_card ? Size{} : framebuffer_size(); }
  GlFunction gl_function(const char* name) const override { return scanout_.context().function(name); }
  const std::string& name() const override { return name_; }
  int quarter_turns() const override { return scanout_.context_turns(); }
  std::int64_t refresh_ns() const override {
    const double hz = refresh_hz(scanout_.mode());
    return hz > 0 ? static_cast<std::int64_t>(1e9 / hz) : 0;
  }
  void context_lost() override { context_lost_ = true; }

  bool ready() const override {
    const FlipQueue& flips = scanout_.flips();
    return state_ == State::on && seat_active_ && !context_lost_ && now_ns() >= busy_until_ &&
           (!flips.pending() || (options_.buffers > 2 && !flips.waiting())) &&
           scanout_.swapchain().has_free();
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
    if (scanout_.flips().pending()) at = std::min(at, scanout_.flips().deadline_ns());
    if (state_ == State::on && busy_until_ > 0) at = std::min(at, busy_until_);
    return at;
  }

  Changes dispatch() override;
  Error present() override;

 private:
  enum class State { no_card, dark, no_master, on };

  void follow_seat();
  void handle_card_events();
  void handle_time(bool look);
  void try_master();
  void look_at_connectors();
  void monitor_gone();
  Error find_card();
  bool open_card();
  void close_card();
  bool open_context();
  Error configure();
  bool try_attempts();
  bool wait_for_flip();
  void flip_done();
  void show_first(int slot);
  void show_again();
  void mode_is_set();
  void show_next(int slot);
  void queue_flip(int slot);
  void refused(int slot, int error, const std::string& what);
  void lose_flip();
  void card_gone(int error);
  void forget_screen();
  void rest(State state, std::int64_t retry);
  Size framebuffer_size() const {
    return {static_cast<int>(scanout_.width()), static_cast<int>(scanout_.height())};
  }

  KmsOptions options_;
  Seat& seat_;
  ConsoleState& console_;
  KmsLog log_;
  KmsChoice choice_;
  KmsCard card_;
  KmsConnector connector_;
  KmsScanout scanout_;  // on card_ and connector_
  HotplugMonitor hotplug_;
  ResumeTimer resume_;
  std::string name_ = "KMS";

  State state_ = State::no_card;
  bool seat_active_ = true;
  bool context_lost_ = false;
  bool mode_set_ = false;  // the screen shows the swapchain's pictures
  bool told_ = false;      // what is shown was said
  Changes changes_;        // not yet told
  std::int64_t retry_at_ = 0;
  std::int64_t busy_until_ = 0;
  std::int64_t possible_since_ = 0;  // when the screen could be used again; 0: it is in use
};

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
    log_.tell("the GL context is lost; making everything anew");
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
    log_.tell("the terminal is switched away");
    wait_for_flip();
    if (card_.is_open() && seat_.sets_master()) drmDropMaster(card_.fd());
    seat_.released();
    mode_set_ = false;
    return;
  }
  log_.tell("the terminal is back");
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
      card_gone(errno != 0 ? errno : ENODEV);
      return;
    }
  }
  const FlipQueue& flips = scanout_.flips();
  if (flips.pending() && now_ns() >= flips.deadline_ns()) lose_flip();
}

void KmsDisplay::card_gone(int error) {
  log_.say(errno_text(card_.path() + ": the card is gone", error));
  close_card();
  rest(State::no_card, kMasterRetry);
}

// Nothing came for a flip: the driver has lost it, or the screen is off. The mode is set anew, which needs no
// event.
void KmsDisplay::lose_flip() {
  times_.flip_lost();
  log_.say("no word of a flip for 100 ms; setting the mode again");
  scanout_.flips().lost();
  mode_set_ = false;
  changes_.redraw = true;
}

void KmsDisplay::handle_time(bool look) {
  retry_at_ = hotplug_.fd() < 0 && state_ == State::on ? now_ns() + kDarkRetry : kNever;
  if (!seat_active_) return;
  switch (state_) {
    case State::no_card:
      if (const Error error = find_card(); !error.ok()) log_.say(error.text());
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
    log_.tell("this program has the screen again");
    possible_since_ = now_ns();
    look_at_connectors();
  } else if (error == -ENODEV) {
    card_gone(error);
  } else {
    rest(State::no_master, kMasterRetry);
  }
}

// The card is open: is its monitor there, and the same?
void KmsDisplay::look_at_connectors() {
  std::vector<KmsConnector> connectors;
  if (const Error error = card_.read_connectors(connectors); !error.ok()) {
    const bool gone = errno == ENODEV;
    log_.say(card_.path() + ": " + error.text());
    if (gone) close_card();
    rest(card_.is_open() ? State::dark : State::no_card, kNoCardRetry);
    return;
  }
  const std::size_t found = choice_.pick(connectors, connector_.id);
  if (found == connectors.size()) {
    monitor_gone();
    return;
  }
  const bool was_on = state_ == State::on;
  const bool same_connector = connectors[found].id == connector_.id;
  connector_ = std::move(connectors[found]);
  std::size_t mode = kNoMode;
  if (const Error error = choice_.choose(connector_, mode); !error.ok()) {
    log_.say(error.text());
    mode_set_ = false;
    rest(State::dark, kDarkRetry);
    return;
  }
  if (!was_on && possible_since_ == 0) possible_since_ = now_ns();
  if (same_connector && scanout_.plan().wants(connector_.modes[mode]) && scanout_.has_surface()) {
    if (state_ == State::dark) log_.tell(connector_.name + ": the monitor is back");
    rest(State::on, hotplug_.fd() < 0 ? kDarkRetry : kNever);
    if (!was_on) show_again();
    return;
  }
  if (const Error error = configure(); !error.ok()) {
    log_.say(error.text());
    rest(State::dark, kDarkRetry);
  }
}

void KmsDisplay::monitor_gone() {
  if (state_ == State::on || state_ == State::no_master) {
    log_.tell(connector_.name + ": the monitor is gone");
  }
  mode_set_ = false;
  rest(State::dark, kDarkRetry);
  if (choice_.is_on_another_card(card_)) {
    close_card();
    rest(State::no_card, 0);
  }
}

// The error is the user's: a monitor is there, and the wanted mode is not.
Error KmsDisplay::find_card() {
  choice_.find(card_, connector_);
  if (!card_.is_open()) {
    log_.say("waiting for a monitor");
    rest(State::no_card, kNoCardRetry);
    return {};
  }
  std::size_t mode = kNoMode;
  Error error = choice_.choose(connector_, mode);
  if (error.ok() && possible_since_ == 0) possible_since_ = now_ns();
  if (!error.ok() || !open_card()) {
    close_card();
    rest(State::no_card, kNoCardRetry);
  }
  return error;
}

bool KmsDisplay::open_card() {
  if (seat_.sets_master() && drmIsMaster(card_.fd()) == 0) drmSetMaster(card_.fd());
  Error error = scanout_.open();
  changes_.rebuild = true;
  if (error.ok()) error = configure();
  if (!error.ok()) log_.say(error.text());
  return error.ok();
}

bool KmsDisplay::open_context() {
  const Error error = scanout_.open_context();
  if (!error.ok()) log_.say(error.text());
  changes_.rebuild = true;
  return error.ok();
}

void KmsDisplay::close_card() {
  mode_set_ = false;
  scanout_.close();
  card_.close();
  connector_ = {};
  changes_.rebuild = true;
}

void KmsDisplay::forget_screen() {
  mode_set_ = false;
  scanout_.forget();
}

Error KmsDisplay::configure() {
  wait_for_flip();
  std::size_t mode = kNoMode;
  if (Error error = choice_.choose(connector_, mode); !error.ok()) return error;
  mode_set_ = false;
  if (Error error = scanout_.configure(mode); !error.ok()) return error;
  if (!try_attempts()) return connector_.name + ": no way to show a picture works";
  rest(State::on, hotplug_.fd() < 0 ? kDarkRetry : kNever);
  return {};
}

bool KmsDisplay::try_attempts() {
  const Size before = framebuffer_size();
  mode_set_ = false;
  if (!scanout_.try_attempts()) return false;
  if (!(before == framebuffer_size())) changes_.rebuild = true;
  changes_.redraw = true;
  told_ = false;
  return true;
}

void KmsDisplay::flip_done() {
  FlipQueue& flips = scanout_.flips();
  if (!flips.pending()) return;
  flips.flipped();
  times_.shown(now_ns(), refresh_ns());
  if (flips.waiting()) queue_flip(flips.take_waiting());
}

// Whether none is under way in the end. Gives up after 100 ms.
bool KmsDisplay::wait_for_flip() {
  while (scanout_.flips().pending()) {
    const std::int64_t left = scanout_.flips().deadline_ns() - now_ns();
    pollfd fd{card_.fd(), POLLIN, 0};
    if (left > 0) poll(&fd, 1, static_cast<int>(left / kMillisecond) + 1);
    handle_card_events();  // which ends the waiting at the deadline
    if (!card_.is_open()) return false;
  }
  return true;
}

Error KmsDisplay::present() {
  if (state_ != State::on || !seat_active_ || context_lost_) return {};
  if (options_.buffers == 2 && !wait_for_flip()) return {};
  if (scanout_.flips().waiting() && !wait_for_flip()) return {};
  Error error;
  switch (scanout_.context().swap(error)) {
    case GbmContext::Swapped::done:
      break;
    case GbmContext::Swapped::context_lost:
      context_lost_ = true;
      return {};
    case GbmContext::Swapped::failed:
      log_.say(card_.path() + ": " + error.text());
      close_card();
      rest(State::no_card, kNoCardRetry);
      return {};
  }
  int slot = FlipQueue::kNone;
  error = scanout_.swapchain().take_front(slot);
  if (!error.ok()) {
    log_.say(card_.path() + ": " + error.text());
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
  const int error = scanout_.set_mode(slot);
  if (error != 0) {
    refused(slot, error, scanout_.set_mode_text());
    return;
  }
  scanout_.flips().set(slot);
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
    if (told_) log_.tell("the picture is back after " + std::to_string((now - since) / kMillisecond) + " ms");
  }
  log_.forget();
  if (told_) return;
  told_ = true;
  const std::string how = scanout_.plan().text();
  name_ = "KMS " + connector_.name + " " + how;
  log_.tell("showing on " + card_.path() + " (" + card_.driver() + ") " + connector_.name + " " + how + ", " +
            std::to_string(options_.buffers) + " buffers" +
            (scanout_.plane_turns() != 0     ? ", turned by the plane"
             : scanout_.context_turns() != 0 ? ", turned by the projection"
                                             : ""));
}

// The screen can be used again and the last picture is still in its buffer: nothing needs to be drawn.
void KmsDisplay::show_again() {
  mode_set_ = false;
  wait_for_flip();
  if (!card_.is_open()) return;
  const int slot = scanout_.flips().on_screen();
  const int error = slot == FlipQueue::kNone ? -ENOENT : scanout_.set_mode(slot);
  if (error == 0) {
    mode_is_set();
  } else if (not_master(error)) {
    rest(State::no_master, kMasterRetry);
  } else {
    changes_.redraw = true;  // and whatever else it takes
  }
}

void KmsDisplay::show_next(int slot) {
  if (scanout_.flips().pending()) {
    scanout_.flips().wait(slot);
  } else {
    queue_flip(slot);
  }
}

void KmsDisplay::queue_flip(int slot) {
  const int error = scanout_.flip(slot, this);
  if (error != 0) {
    refused(slot, error, "page flip");
    return;
  }
  scanout_.flips().queued(slot, now_ns() + kFlipWait_ms * kMillisecond);
}

// The driver did not take a frame: what follows from its reason.
void KmsDisplay::refused(int slot, int error, const std::string& what) {
  scanout_.swapchain().release(slot);
  log_.say(connector_.name + ": " + errno_text(what, error));
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
  } else if (scanout_.plan().has_next()) {
    scanout_.plan().advance();
    log_.tell("trying " + scanout_.plan().text());
    if (!try_attempts()) rest(State::dark, kDarkRetry);
  } else {
    log_.tell(connector_.name + ": no way to show a picture works; trying again");
    scanout_.plan().clear();
    rest(State::dark, kDarkRetry);
  }
}

}  // namespace

std::unique_ptr<Display> open_kms_display(const KmsOptions& options, Seat& seat, ConsoleState& console,
                                          const LogLine& log, Error& error, const EglApi& egl) {
  auto display = std::make_unique<KmsDisplay>(options, seat, console, log, egl);
  error = display->start();
  if (!error.ok()) return nullptr;
  return display;
}

}  // namespace karst
