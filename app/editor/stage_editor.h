// SPDX-License-Identifier: MIT
// Edits by hand in the loop of a program with a stage, drawn over its pictures: karst view --edit.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "app/editor/edit_session.h"
#include "app/editor/hand_editor.h"
#include "app/overlay/overlay.h"
#include "app/stage/stage.h"
#include "platform/base/error.h"
#include "platform/frame_times.h"
#include "platform/input.h"

namespace karst::app {

class StageEditor {
 public:
  explicit StageEditor(std::function<void(const std::string&)> say) : say_(std::move(say)) {}
  StageEditor(const StageEditor&) = delete;
  StageEditor& operator=(const StageEditor&) = delete;
  ~StageEditor() { end(); }

  // Before the world is loaded, from base(). Where it is not called, nothing happens in any of the others.
  // bytes: of memory for edits, about.
  Error open(const EditSession::Files& files, std::uint64_t bytes);
  const std::string& base() const { return session_.base(); }
  StageNeeds needs(StageNeeds others) const;
  // The stage outlives this object, or end() is called before.
  Error begin(Stage& stage);
  // Tells of what is not saved.
  void end();

  // Of the stage's context.
  Error attach(Display& display);
  void detach(bool lost);

  // camera: called with what the camera is to make of the event. Whether the picture differs from then on.
  bool handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera);
  bool is_busy() const { return hand_ && hand_->is_busy(); }

  // Edits before a frame, which is drawn over then.
  void before_frame(StageView& view, int quarter_turns, std::int64_t now_ns);
  // After it: whether there is more to do in the next one.
  bool take_changed() { return hand_ && hand_->take_changed(); }
  // Milliseconds of the frames' edits, those alone that changed the world, or did a part of that.
  const Series& edit_ms() const { return edit_ms_; }

 private:
  bool open_ = false;
  std::uint64_t edit_bytes_ = 0;
  std::string world_name_;
  std::function<void(const std::string&)> say_;
  EditSession session_;
  World* world_ = nullptr;
  Query* query_ = nullptr;
  std::optional<HandEditor> hand_;
  Series edit_ms_;
  OverlayMesh mesh_;
  Overlay overlay_;
};

}  // namespace karst::app
