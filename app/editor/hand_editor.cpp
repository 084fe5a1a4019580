// SPDX-License-Identifier: MIT
#include "app/editor/hand_editor.h"

#include <linux/input-event-codes.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/geometric.hpp>

#include "app/editor/outline.h"

namespace karst::app {
namespace {

// Where the brush stands still, tools of voxels go on so often, those of heights so often.
constexpr std::int64_t kVoxelPause_ns = 250'000'000, kHeightPause_ns = 50'000'000;
constexpr double kStepWork_ms = 4;  // of a frame, for a step that is taken back
constexpr double kMoved = 0.25;     // radii: sooner, where it moved so far
constexpr double kClear = 1.75;     // radii, or sides of a voxel: nearer to the eye nothing is filled
constexpr double kJoined = 2.0;     // radii: so far apart, two places of a stroke are dug as one way

constexpr Rgba kBrushColour{255, 226, 84, 255}, kFaintColour{255, 226, 84, 110},
    kVoxelColour{96, 220, 255, 255};
constexpr Rgba kTextColour{238, 238, 230, 255}, kErrorColour{255, 128, 112, 255}, kBack{0, 0, 0, 150};

bool has_voxels(const WorldInfo& info) {
  return info.ground_samples[0] == 0 || info.regions > 0 || info.can_be_dug;
}

double unit_m(const WorldInfo& info) {
  if (info.field_samples[0] > 0) return info.field_cell_m;
  return has_voxels(info) ? info.voxel_size_m : info.ground_spacing_m[0];
}

}  // namespace

const HandEditor::Key HandEditor::kKeys[] = {
    {KEY_T, Command::tool, 1},           {KEY_B, Command::shape, 1},
    {KEY_P, Command::draw_on, 1},        {KEY_LEFTBRACE, Command::size, -1},
    {KEY_RIGHTBRACE, Command::size, 1},  {KEY_MINUS, Command::strength, -1},
    {KEY_EQUAL, Command::strength, 1},   {KEY_I, Command::offset, -1},
    {KEY_O, Command::offset, 1},         {KEY_J, Command::slope, -1},
    {KEY_K, Command::slope, 1},          {KEY_COMMA, Command::octree_level, -1},
    {KEY_DOT, Command::octree_level, 1}, {KEY_M, Command::material, 1},
    {KEY_Z, Command::undo, 1},           {KEY_Y, Command::redo, 1},
    {KEY_F5, Command::save, 1},          {KEY_H, Command::help, 1}};

HandEditor::HandEditor(const World& world, Query& query, EditSession& session)
    : query_(&query),
      session_(&session),
      brush_(unit_m(world.info()), world.info().octree_depth, has_voxels(world.info())),
      aim_(world, query) {
  const WorldInfo& info = world.info();
  std::vector<std::string> materials;
  for (std::uint32_t m = 0; m < info.materials; ++m) materials.emplace_back(info.material_names[m]);
  brush_.set_materials(std::move(materials));
  if (info.field_samples[0] > 0 && info.patches == 0 && info.ground_samples[0] == 0) brush_.set_of_field();
}

void HandEditor::say(std::string text, bool is_error) {
  if (is_error) news_ = text;
  message_ = std::move(text);
  is_error_ = is_error;
  changed_ = true;
}

// --- input

void HandEditor::handle(const InputEvent& event, const std::function<void(const InputEvent&)>& camera) {
  switch (event.kind) {
    case InputEvent::Kind::key:
      if (!handle_key(event)) camera(event);
      break;
    case InputEvent::Kind::button:
      if (event.code == BTN_LEFT) {
        held_ = event.pressed;
        tapped_ = tapped_ || event.pressed;
        changed_ = true;
      } else if (event.code == BTN_RIGHT) {
        // Turns the camera, as the left one does where nothing is edited.
        keys_.right = event.pressed;
        InputEvent turns = event;
        turns.code = BTN_LEFT;
        camera(turns);
      }
      break;
    case InputEvent::Kind::pointer:
    case InputEvent::Kind::place:
      changed_ = changed_ || !has_pointer_ || pointer_ != glm::dvec2(event.x, event.y);
      fingers_.forget();
      has_pointer_ = true;
      pointer_ = {event.x, event.y};
      camera(event);
      break;
    case InputEvent::Kind::motion:
      if (!has_pointer_ && fingers_.points()) {
        fingers_.forget();
        pointer_ = glm::dvec2(0.5);
      }
      // A mouse without a pointer turns the camera, so that its middle goes where the mouse does.
      if (!has_pointer_ && !keys_.right) {
        InputEvent drag;
        drag.kind = InputEvent::Kind::button;
        drag.code = BTN_LEFT;
        drag.pressed = true;
        camera(drag);
        camera(event);
        drag.pressed = false;
        camera(drag);
      } else {
        camera(event);
      }
      break;
    case InputEvent::Kind::wheel:
      if (keys_.shift || keys_.control) {
        camera(event);
      } else {
        const int steps = event.y < 0 ? 1 : -1;
        asked_.push_back({Command::size, steps});
        changed_ = true;
      }
      break;
    case InputEvent::Kind::touch:
    case InputEvent::Kind::untouch:
      handle_finger(event, camera);
      break;
  }
}

void HandEditor::handle_finger(const InputEvent& event,
                               const std::function<void(const InputEvent&)>& camera) {
  use_tool(fingers_.handle(event, camera));
  if (fingers_.points()) pointer_ = fingers_.at();
  changed_ = true;
}

void HandEditor::use_tool(Fingers::Tool tool) {
  if (tool == Fingers::Tool::press) held_ = true;
  if (tool == Fingers::Tool::release) held_ = false;
  if (tool == Fingers::Tool::tap) tapped_ = true;
}

// Whether it was the editor's.
bool HandEditor::handle_key(const InputEvent& event) {
  if (event.code == KEY_LEFTSHIFT || event.code == KEY_RIGHTSHIFT) keys_.shift = event.pressed;
  if (event.code == KEY_LEFTCTRL || event.code == KEY_RIGHTCTRL) keys_.control = event.pressed;
  if (event.code == KEY_SPACE || event.code == KEY_ENTER) {
    held_ = event.pressed;
    tapped_ = tapped_ || event.pressed;
    changed_ = true;
    return true;
  }
  for (const Key& key : kKeys) {
    if (key.code != event.code) continue;
    constexpr std::size_t kMostAsked = 64;  // more than a frame's hands: what floods is left out
    if (event.pressed && asked_.size() < kMostAsked) {
      const bool cycles = key.command <= Command::draw_on || key.command == Command::material;
      asked_.push_back({key.command, cycles && keys_.shift ? -key.steps : key.steps});
      changed_ = true;
    }
    return true;
  }
  return false;
}

void HandEditor::run(const Asked& asked) {
  if (!message_.empty()) say("", false);
  switch (asked.command) {
    case Command::tool:
      return brush_.next_tool(asked.steps);
    case Command::shape:
      return brush_.next_shape(asked.steps);
    case Command::draw_on:
      return brush_.next_draw_on(asked.steps);
    case Command::size:
      return brush_.resize(asked.steps);
    case Command::strength:
      return brush_.strengthen(asked.steps);
    case Command::offset:
      return brush_.lift(asked.steps);
    case Command::slope:
      return brush_.tilt(asked.steps);
    case Command::octree_level:
      return brush_.refine(asked.steps);
    case Command::material:
      return brush_.next_material(asked.steps);
    case Command::undo:
      return take_step(true);
    case Command::redo:
      return take_step(false);
    case Command::save:
      saves_next_ = true;  // when that has been seen
      return say("saving to " + session_->output() + " ...", false);
    case Command::help:
      shows_help_ = !shows_help_;
      return;
  }
}

// As much of it as a frame has time for.
void HandEditor::take_step(bool back) {
  bool changed = false;
  const Error error = session_->take_step(back, kStepWork_ms, changed);
  if (!error.ok()) return say(error.text(), true);
  if (session_->is_taking()) return;
  changes_ += changed;
  if (!changed) say(back ? "there is nothing to take back" : "there is nothing to do again", false);
}

void HandEditor::save() {
  if (Error error = session_->save(); !error.ok()) return say(error.text(), true);
  say("saved to " + session_->output(), false);
}

// --- strokes

void HandEditor::frame(const ViewState& view, int quarter_turns, std::int64_t now_ns) {
  const auto aim = [&] { aimed_ = aim_.at(brush_, view, quarter_turns, pointer_); };
  if (session_->is_pending()) {
    EditResult told;
    session_->advance(told);
    changes_ += told.changed;
    changed_ = true;
  }
  if (std::exchange(saves_next_, false)) save();
  // What is asked for waits until a step is taken.
  if (session_->is_taking()) take_step(session_->takes_back());
  std::size_t done = 0;
  for (; done < asked_.size() && !session_->is_taking(); ++done) {
    end_stroke();
    run(asked_[done]);
  }
  asked_.erase(asked_.begin(), asked_.begin() + static_cast<std::ptrdiff_t>(done));
  aim();
  use_tool(fingers_.frame(now_ns, aimed_.found));
  const bool waits = is_working();
  if (is_drawing() && !waits) {
    draw_stroke(now_ns);
    aim();
  }
  if (!held_) end_stroke();
  tapped_ = tapped_ && waits;
  changed_ = changed_ || is_working();
}

void HandEditor::end_stroke() {
  if (!stroke_) return;
  stroke_.reset();
  aim_.end_stroke();
  if (const Error error = session_->end_stroke(); !error.ok()) say("autosave: " + error.text(), true);
}

void HandEditor::draw_stroke(std::int64_t now_ns) {
  if (!stroke_) {
    if (!aim_.begin_stroke(brush_)) return;
    if (!message_.empty()) say("", false);
    stroke_ = Stroke{};
    session_->begin_stroke();
  }
  if (!dab(now_ns)) {
    // What cannot be done is not tried again with each frame.
    held_ = false;
  }
}

// False: it failed, and says so.
bool HandEditor::dab(std::int64_t now_ns) {
  if (!aimed_.found) return true;
  const bool voxels = of_voxels(brush_.tool());
  const bool cubes = brush_.shape() == HandShape::voxel;
  const double unit = cubes ? aimed_.voxel_side_m : brush_.radius_m();
  const double moved = glm::length(aimed_.place - stroke_->last);
  const std::int64_t pause = voxels ? kVoxelPause_ns : kHeightPause_ns;
  const bool is_due = now_ns - stroke_->at_ns >= pause;
  if (stroke_->edits > 0) {
    // The surface gives way under the tool: that the place is another one says nothing of the hand.
    const bool hand_moved = voxels && aim_.apart_m(stroke_->surface) >= kMoved * unit;
    if (!is_due && !hand_moved) return true;
    // On a plane nothing more comes of standing still.
    if (voxels && moved < 1e-9) return true;
  }
  // Rock does not grow around the eye.
  if (brush_.tool() == Tool::fill && glm::length(aimed_.place - aim_.eye()) < kClear * unit) return true;
  Edit edit = brush_.make_edit(aimed_.place, aim_.plane_up(), stroke_->edits);
  if (stroke_->edits > 0 && voxels && brush_.shape() == HandShape::sphere && moved <= kJoined * unit) {
    edit.shape = BrushShape::capsule;
    edit.to = {stroke_->last.x, stroke_->last.y, stroke_->last.z};
  }
  EditResult result;
  const Error error = session_->apply(edit, result);
  changes_ += result.changed;
  stroke_->last = aimed_.place;
  stroke_->surface = aimed_.surface;
  stroke_->at_ns = now_ns;
  ++stroke_->edits;
  if (!error.ok()) {
    say(error.text(), true);
    return false;
  }
  return true;
}

// --- what is drawn

std::string HandEditor::state() const {
  std::string text = brush_.text() + "  |  undo " + std::to_string(session_->undo_steps()) + ", redo " +
                     std::to_string(session_->redo_steps()) + "  |  ";
  if (session_->is_saved()) return text + "saved";
  return text + (session_->journal_error().ok() ? "not saved yet" : "not saved, and not in the journal");
}

std::vector<std::string> HandEditor::help() const {
  return {std::string("space, left button or a finger: ") +
          (of_voxels(brush_.tool()) ? "digs or fills" : "draws") +
          ", held: a stroke   right button: turns   w a s d q e arrows: move   1 2 3: fly orbit walk   "
          "h: help   F5: save   z: undo   y: redo   t: tool   b: shape   p: where it is drawn   "
          "[ ] wheel: size   - =: strength   i o: offset   , .: octree level   j k: slope   m: material"};
}

void HandEditor::draw(OverlayMesh& mesh) const {
  const auto lines = [&](const std::vector<OutlinePart>& parts, Rgba colour) {
    for (const OutlinePart& part : parts) mesh.line(part.from, part.to, colour);
  };
  if (aimed_.found) {
    const double radius = brush_.radius_m();
    const glm::dvec3 up(0, 1, 0);
    switch (brush_.shape()) {
      case HandShape::voxel:
        lines(cube_edges(aimed_.place, aimed_.voxel_side_m * 1.02), kVoxelColour);
        break;
      case HandShape::box:
        lines(square_on(*query_, aimed_.place, radius), kBrushColour);
        if (of_voxels(brush_.tool())) lines(cube_edges(aimed_.place, 2 * radius), kFaintColour);
        break;
      case HandShape::sphere:
      case HandShape::cylinder:
        lines(ring_on(*query_, aimed_.surface, of_voxels(brush_.tool()) ? aimed_.normal : up, radius),
              kBrushColour);
        if (of_voxels(brush_.tool())) lines(circle(aimed_.place, aimed_.normal, radius), kFaintColour);
        break;
    }
  }
  const double width = mesh.size().x, height = mesh.size().y;
  const int scale = std::max(1, static_cast<int>(std::min(height / 360, width / 640)));
  const double margin = 4.0 * scale, step = kLineAdvance * scale;
  const auto letters =
      static_cast<std::size_t>(std::max(1.0, std::floor((width - 2 * margin) / (kLetterAdvance * scale))));
  if (!has_pointer_ && !fingers_.points()) {
    const double arm = 6.0 * scale, thick = scale;
    mesh.box(width / 2 - arm, height / 2 - thick / 2, 2 * arm, thick, kTextColour);
    mesh.box(width / 2 - thick / 2, height / 2 - arm, thick, 2 * arm, kTextColour);
  }
  const auto print = [&](const std::vector<std::string>& texts, double& y, bool upwards, Rgba colour) {
    std::vector<std::string_view> rows;
    for (const std::string& text : texts) {
      for (const std::string_view row : wrap_text(text, letters)) rows.push_back(row);
    }
    if (rows.empty()) return;
    const double tall = step * static_cast<double>(rows.size()) + margin;
    const double top = std::floor(upwards ? y - tall : y);
    mesh.box(0, top, width, tall, kBack);
    for (std::size_t n = 0; n < rows.size(); ++n)
      mesh.text(margin, top + 2.0 * scale + step * static_cast<double>(n), scale, rows[n], colour);
    y = upwards ? top : top + tall;
  };
  double bottom = height, top = 0;
  print({state()}, bottom, true, kTextColour);
  if (!message_.empty()) print({message_}, bottom, true, is_error_ ? kErrorColour : kBrushColour);
  if (shows_help_) print(help(), top, false, kTextColour);
}

}  // namespace karst::app
