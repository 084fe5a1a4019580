// SPDX-License-Identifier: MIT
// Edits by hand: keys, mouse and time go in, edits of the world come out, and what is to be drawn over the
// picture. Knows no OpenGL. docs/editing.md has the keys.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>

#include "app/editor/aim.h"
#include "app/editor/brush.h"
#include "app/editor/edit_session.h"
#include "app/editor/touch/fingers.h"
#include "app/overlay/overlay_mesh.h"
#include "karst/query.h"
#include "karst/world.h"
#include "platform/input.h"

namespace karst::app {

class HandEditor {
 public:
  // All outlive this object; the session has begun.
  HandEditor(const World& world, Query& query, EditSession& session);

  // camera: called with what the camera is to make of the event.
  void handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera);
  // The next picture differs: a command waits, or the pointer moved. Asked once.
  bool take_changed() { return std::exchange(changed_, false); }
  // More pictures are wanted: of a stroke, of an edit or a step back that takes several frames, or to see
  // what a finger will do.
  bool is_busy() const { return is_drawing() || fingers_.waits() || is_working(); }
  // An edit or a step back that takes several frames.
  bool is_working() const { return session_->is_taking() || session_->is_pending(); }

  // What comes with a picture of this view at a time: a part of an edit that takes several, commands, the
  // stroke's next edit, and then where the brush is. A stroke waits for an edit that is under way.
  void frame(const ViewState& view, int quarter_turns, std::int64_t now_ns);
  // After frame(): into a mesh that was started with the same view.
  void draw(OverlayMesh& mesh) const;

  // The end: of a stroke that is under way, too.
  void end() { end_stroke(); }
  // A line on the screen, until the next command.
  void tell(const std::string& text) { say(text, false); }

  // Edits, steps taken back and done again that changed the world.
  std::uint64_t changes() const { return changes_; }

  const Brush& brush() const { return brush_; }
  const std::string& message() const { return message_; }
  // Has something been said that standard error should have, too? Empty: no. Asked once.
  std::string take_news() { return std::exchange(news_, {}); }

 private:
  enum class Command : std::uint8_t {
    tool,
    shape,
    draw_on,
    size,
    strength,
    offset,
    slope,
    octree_level,
    material,
    undo,
    redo,
    save,
    help
  };
  struct Asked {
    Command command;
    int steps;  // -1: back, or less
  };
  struct Key {
    unsigned code;
    Command command;
    int steps;
  };
  static const Key kKeys[];

  bool is_drawing() const { return held_ || tapped_; }
  bool handle_key(const InputEvent& event);
  void handle_finger(const InputEvent& event, const std::function<void(const InputEvent&)>& camera);
  void use_tool(Fingers::Tool tool);
  void run(const Asked& asked);
  void take_step(bool back);
  void save();
  void draw_stroke(std::int64_t now_ns);
  void end_stroke();
  bool dab(std::int64_t now_ns);
  void say(std::string text, bool is_error);
  std::vector<std::string> help() const;
  std::string state() const;

  // Of the stroke that is under way.
  struct Stroke {
    glm::dvec3 last{0}, surface{0};  // where the last edit was, and what the pointer was at
    std::int64_t at_ns = 0;          // and when
    std::uint32_t edits = 0;
  };
  // What is held down.
  struct Held {
    bool shift = false, control = false, right = false;
  };

  Query* query_;
  EditSession* session_;
  Brush brush_;
  Aim aim_;
  Aimed aimed_;
  glm::dvec2 pointer_{0.5};
  bool has_pointer_ = false;  // else the picture's middle
  Fingers fingers_;
  Held keys_;
  bool held_ = false, tapped_ = false;  // the drawing key or button: down; pressed since the last frame
  std::optional<Stroke> stroke_;
  std::vector<Asked> asked_;
  bool changed_ = true;
  bool saves_next_ = false;
  std::uint64_t changes_ = 0;
  bool shows_help_ = true;
  std::string message_, news_;
  bool is_error_ = false;
};

}  // namespace karst::app
