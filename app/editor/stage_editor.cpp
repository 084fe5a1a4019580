// SPDX-License-Identifier: MIT
#include "app/editor/stage_editor.h"

#include <algorithm>

#include "platform/base/clock.h"

namespace karst::app {
namespace {

constexpr std::uint32_t kQueryPatches = 256;  // a brush and its ring

}  // namespace

Error StageEditor::open(const EditSession::Files& files, std::uint64_t bytes) {
  edit_bytes_ = bytes;
  world_name_ = files.world;
  if (Error error = session_.open(files); !error.ok()) return error;
  open_ = true;
  return {};
}

StageNeeds StageEditor::needs(StageNeeds others) const {
  if (!open_) return others;
  ++others.queries;
  others.query_patches = std::max(others.query_patches, kQueryPatches);
  others.edit_bytes = edit_bytes_;
  others.overlay_bytes = Overlay::bytes();
  return others;
}

Error StageEditor::begin(Stage& stage) {
  if (!open_) return {};
  world_ = &stage.world();
  if (Error error = session_.begin(*world_); !error.ok()) return error;
  if (const Status status = world_->take_query(query_); !status.ok()) return {world_name_, status};
  hand_.emplace(*world_, *query_, session_);
  if (session_.found() == 0) return {};
  const std::string count = std::to_string(session_.found()) +
                            (session_.found() == 1 ? " edit that was" : " edits that were") + " not saved";
  hand_->tell(session_.discards() ? count + ": thrown away"
                                  : count + ": done again; --discard-edits throws it away");
  say_(world_name_ + ": " + hand_->message());
  return {};
}

void StageEditor::end() {
  if (!open_) return;
  open_ = false;
  const bool unsaved = hand_ && !session_.is_saved();
  if (hand_) hand_->end();
  hand_.reset();
  session_.end();
  if (query_ != nullptr) world_->release(query_);
  query_ = nullptr;
  if (unsaved)
    say_(world_name_ + ": what is not saved is kept in " + JournalFile::path_for(world_name_) +
         "; karst view --edit goes on with it");
}

Error StageEditor::attach(Display& display) {
  if (!open_) return {};
  const GlLoader loader{
      [](void* user, const char* name) { return static_cast<const Display*>(user)->gl_function(name); },
      &display};
  return {display.name(), overlay_.create(loader)};
}

void StageEditor::detach(bool lost) {
  if (lost) {
    overlay_.forget();
  } else {
    overlay_.destroy();
  }
}

bool StageEditor::handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera) {
  if (!hand_) {
    camera(event);
    return false;
  }
  hand_->handle(event, camera);
  return hand_->take_changed();
}

void StageEditor::before_frame(StageView& view, int quarter_turns, std::int64_t now_ns) {
  view.draw_over = nullptr;
  if (!hand_) return;
  const std::uint64_t changes = hand_->changes();
  const bool busy = hand_->is_working();
  const std::int64_t start = karst::now_ns();
  hand_->frame(view.view, quarter_turns, now_ns);
  if (busy || hand_->is_working() || hand_->changes() != changes)
    edit_ms_.add(ms_between(start, karst::now_ns()));
  if (const std::string news = hand_->take_news(); !news.empty()) say_(news);
  mesh_.start(view.view, quarter_turns);
  hand_->draw(mesh_);
  view.user = this;
  view.draw_over = [](void* user, const ViewState& seen, bool two_ranges) {
    auto* const self = static_cast<StageEditor*>(user);
    self->overlay_.draw(self->mesh_, seen, two_ranges);
  };
}

}  // namespace karst::app
