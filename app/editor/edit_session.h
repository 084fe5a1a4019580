// SPDX-License-Identifier: MIT
// A world that is being edited by hand: its editor, its journal and its file. What was done is in the journal
// when a call returns, so that whatever ends the program, the next one does it again.
//
//   EditSession session;
//   session.open(files);    // nobody else edits it from here on
//   session.begin(world);   // loaded from session.base(): does again what an earlier program left
//   session.begin_stroke();  session.apply(edit, changed) ...  session.end_stroke();
//   session.save();
//   session.end();
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "app/edit/edit_script.h"
#include "app/edit/journal_file.h"
#include "karst/edit.h"
#include "karst/world.h"
#include "platform/base/error.h"

namespace karst::app {

class EditSession {
 public:
  struct Files {
    std::string world;     // that is edited
    std::string output;    // where it is saved; empty: the world itself
    bool discard = false;  // forgets what an earlier program left
  };

  EditSession() = default;
  EditSession(const EditSession&) = delete;
  EditSession& operator=(const EditSession&) = delete;
  ~EditSession() { end(); }

  // Takes the journal of the world. The error says so where another program is editing it.
  Error open(const Files& files);
  // The file that the world is to be loaded from: its own, or WORLD.autosave where the journal is of that.
  const std::string& base() const { return base_; }
  // Edits of an earlier program that begin() does again, or that were thrown away.
  std::size_t found() const { return found_; }
  // Takes the world's editor; the world outlives end(). progress: may be empty.
  Error begin(World& world);
  // Gives it back. The journal is removed where all is saved.
  void end();

  void begin_stroke();
  // Changes nothing where it fails. What takes long is begun, and goes on with advance(); all other calls do
  // it first.
  Error apply(const Edit& edit, EditResult& result);
  bool is_pending() const { return editor_ != nullptr && editor_->is_pending(); }
  // A part of it, for a frame. result: Editor::advance()'s.
  void advance(EditResult& result);
  Error end_stroke();
  // changed false: there is nothing. What was done before the world was saved in place the journal does not
  // know any more: then all of the world is saved to WORLD.autosave, which the journal is of from then on.
  Error undo(bool& changed) { return take_step(true, kWhole_ms, changed); }
  Error redo(bool& changed) { return take_step(false, kWhole_ms, changed); }
  // The same in pieces of about so many milliseconds. Where is_taking() afterwards, the step is not done yet,
  // and the same again goes on with it; nothing else is called meanwhile, but end().
  Error take_step(bool back, double most_ms, bool& changed);
  bool is_taking() const { return editor_ != nullptr && editor_->undo_state().is_taking; }
  bool takes_back() const { return takes_back_; }
  Error save();

  // Whether the output holds all of it.
  bool is_saved() const { return done_ == saved_at_ && !lost_saved_; }
  std::size_t undo_steps() const;
  std::size_t redo_steps() const;
  // What kept a step out of the journal; ok: all are in it. It is tried anew with the next save.
  const Error& journal_error() const { return journal_error_; }
  const std::string& output() const { return files_.output; }
  bool discards() const { return files_.discard; }

 private:
  static constexpr double kWhole_ms = std::numeric_limits<double>::infinity();

  Error replay();
  Error note_step(bool back);
  void finish();
  void note(const ScriptStep& step, bool on_disk);
  void note(ScriptStep::Kind kind);
  Error begin_journal(std::uint64_t id, bool of_checkpoint);
  void checkpoint();
  void remove_checkpoint();
  // A state of the world that is like no other: the strokes that made it.
  using Strokes = std::vector<std::uint64_t>;

  Files files_;
  World* world_ = nullptr;
  Editor* editor_ = nullptr;
  JournalFile journal_;
  std::vector<ScriptStep> recovered_;
  std::string base_;
  std::size_t found_ = 0;
  Strokes done_, undone_;
  Strokes saved_at_;         // done_ when it was saved
  bool lost_saved_ = false;  // loaded from WORLD.autosave: the saved state is not known
  // Those of done_ that were done before the journal was begun; how many the journal can do again.
  std::size_t journal_begin_ = 0, journal_undone_ = 0;
  std::uint64_t strokes_ = 0;
  bool in_place_ = true, begun_ = false;
  bool in_stroke_ = false, stroke_changed_ = false, takes_back_ = false;
  Error journal_error_;
};

}  // namespace karst::app
