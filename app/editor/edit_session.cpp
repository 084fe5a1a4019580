// SPDX-License-Identifier: MIT
#include "app/editor/edit_session.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "app/common/progress.h"
#include "app/edit/save_file.h"
#include "app/files/file_source.h"

namespace karst::app {
namespace {

Error read_world_id(const std::string& path, std::uint64_t& id) {
  FileSource file;
  if (Error error = file.open(path); !error.ok()) return error;
  const Source source = file.source();
  std::array<std::byte, kWorldIdBytes> first{};
  const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(first.size(), source.bytes));
  if (!source.read(source.user, 0, first.data(), count)) return path + ": cannot be read";
  id = world_id(std::span(first).first(count));
  return {};
}

std::string checkpoint_path(const std::string& world) {
  return world + ".autosave";
}

}  // namespace

Error EditSession::open(const Files& files) {
  files_ = files;
  if (files_.output.empty()) files_.output = files_.world;
  std::error_code none;
  in_place_ = files_.output == files_.world || std::filesystem::equivalent(files_.output, files_.world, none);
  std::uint64_t id = 0, other = 0;
  if (Error error = read_world_id(files_.world, id); !error.ok()) return error;
  if (std::filesystem::exists(checkpoint_path(files_.world), none)) {
    if (Error error = read_world_id(checkpoint_path(files_.world), other); !error.ok()) return error;
  }
  if (Error error = journal_.open(files_.world, id, recovered_, other); !error.ok()) return error;
  base_ = files_.world;
  // The world may have been saved by another program before it was ours.
  std::uint64_t again = 0;
  if (Error error = read_world_id(files_.world, again); !error.ok()) return error;
  if (again != id) return files_.world + ": is being saved by another karst; try again";
  ScriptCounts counts;
  recovered_ = effective_steps(recovered_, counts);
  found_ = recovered_.size();
  if (journal_.is_of_other() && !files_.discard) {
    base_ = checkpoint_path(files_.world);
    lost_saved_ = true;
    ++found_;  // the step that was taken back
  } else if (other != 0) {
    remove_checkpoint();
  }
  if (files_.discard) {
    recovered_.clear();
    if (journal_.steps() > 0 || journal_.is_of_other()) return journal_.begin_anew(id);
  }
  return {};
}

Error EditSession::begin(World& world) {
  if (const Status status = world.take_editor(editor_); !status.ok()) return {files_.world, status};
  world_ = &world;
  Error error = replay();
  begun_ = error.ok();
  return error;
}

Error EditSession::replay() {
  Progress progress("edits of the journal", recovered_.size());
  std::size_t count = 0;
  const std::string journal = JournalFile::path_for(files_.world);
  for (const ScriptStep& step : recovered_) {
    if (!step.joined || !in_stroke_) {
      if (in_stroke_) editor_->end_stroke();
      editor_->begin_stroke();
      in_stroke_ = true;
      done_.push_back(++strokes_);
    }
    EditResult result;
    if (const Status status = editor_->apply(step.what, result); !status.ok()) {
      return Error(journal + ": edit " + std::to_string(count), status).text() +
             "; --discard-edits throws what it has away";
    }
    progress.update(++count);
  }
  if (in_stroke_) editor_->end_stroke();
  in_stroke_ = false;
  recovered_.clear();
  return {};
}

void EditSession::end() {
  if (bool changed = false; is_taking()) static_cast<void>(take_step(takes_back_, kWhole_ms, changed));
  if (editor_ != nullptr) world_->release(editor_);
  editor_ = nullptr;
  // What begin() has not done again is still wanted.
  if (begun_ && is_saved()) {
    journal_.remove();
    remove_checkpoint();
  } else {
    journal_.close();
  }
  begun_ = false;
}

// Where the journal cannot take a step, those that follow it would do something else.
void EditSession::note(const ScriptStep& step, bool on_disk) {
  if (!journal_error_.ok()) return;
  journal_error_ = journal_.append(step, on_disk);
}

void EditSession::note(ScriptStep::Kind kind) {
  ScriptStep step;
  step.kind = kind;
  note(step, true);
}

Error EditSession::begin_journal(std::uint64_t id, bool of_checkpoint) {
  journal_begin_ = done_.size();
  journal_undone_ = 0;
  return journal_error_ = journal_.begin_anew(id, of_checkpoint);
}

// Until the journal is begun anew it is of what it was of, and the new file means nothing.
void EditSession::checkpoint() {
  std::uint64_t saved = 0, bytes = 0;
  const SaveReady ready = [&](std::uint64_t id) {
    saved = id;
    return Error();
  };
  journal_error_ = save_file(*editor_, checkpoint_path(files_.world), ready, bytes);
  if (journal_error_.ok()) journal_error_ = begin_journal(saved, true);
}

void EditSession::remove_checkpoint() {
  std::error_code none;
  std::filesystem::remove(checkpoint_path(files_.world), none);
}

void EditSession::begin_stroke() {
  editor_->begin_stroke();
  in_stroke_ = true;
  stroke_changed_ = false;
}

// Those that are begun have their changes for certain.
Error EditSession::apply(const Edit& edit, EditResult& result) {
  if (const Status status = editor_->start(edit, result); !status.ok()) {
    const std::string_view field = status.field() == nullptr ? "" : status.field();
    const bool room = field == "edit_patches" || field == "edit_tiles" || field == "region_patches" ||
                      field == "field_sample_blocks" || field == "field_material_blocks";
    const Error error("edit", status);
    return room ? Error(error.text() + "; --edit-memory takes more") : error;
  }
  if (!result.changed && !result.pending) return {};
  ScriptStep step;
  step.joined = in_stroke_ && stroke_changed_;
  step.what = edit;
  if (!step.joined) {
    done_.push_back(++strokes_);
    undone_.clear();
    journal_undone_ = 0;
  }
  stroke_changed_ = true;
  note(step, !in_stroke_);
  return {};
}

void EditSession::advance(EditResult& result) {
  result = {};
  if (editor_ != nullptr) editor_->advance(result);
}

void EditSession::finish() {
  for (EditResult result; is_pending();) editor_->advance(result);
}

Error EditSession::end_stroke() {
  editor_->end_stroke();
  in_stroke_ = false;
  if (stroke_changed_ && journal_error_.ok()) journal_error_ = journal_.sync();
  return journal_error_;
}

std::size_t EditSession::undo_steps() const {
  return editor_ == nullptr ? 0 : std::min<std::size_t>(editor_->undo_state().undo_steps, done_.size());
}
std::size_t EditSession::redo_steps() const {
  return editor_ == nullptr ? 0 : std::min<std::size_t>(editor_->undo_state().redo_steps, undone_.size());
}

Error EditSession::take_step(bool back, double most_ms, bool& changed) {
  changed = false;
  if (!is_taking()) finish();
  if (!is_taking() && (back ? undo_steps() : redo_steps()) == 0) return {};
  takes_back_ = back;
  const auto steps = [&] {
    const UndoState state = editor_->undo_state();
    return back ? state.undo_steps : state.redo_steps;
  };
  EditResult result;
  const std::uint32_t before = steps();
  const Status status = back ? editor_->undo(result, most_ms) : editor_->redo(result, most_ms);
  if (!status.ok()) return {back ? "undo" : "redo", status};
  // What a step did may have been nothing in all.
  if (steps() == before) return {};
  changed = true;
  return note_step(back);
}

Error EditSession::note_step(bool back) {
  Strokes& from = back ? done_ : undone_;
  (back ? undone_ : done_).push_back(from.back());
  from.pop_back();
  const bool in_journal = back ? done_.size() >= journal_begin_ : journal_undone_ > 0;
  if (in_journal) {
    back ? ++journal_undone_ : --journal_undone_;
    note(back ? ScriptStep::undo : ScriptStep::redo);
  } else {
    checkpoint();
  }
  return journal_error_;
}

// In place, the journal is of the new world from then on. Elsewhere the world that is edited is what it was.
Error EditSession::save() {
  std::uint64_t saved = 0, bytes = 0;
  const SaveReady ready = [&](std::uint64_t id) {
    saved = id;
    return in_place_ && journal_error_.ok() ? journal_.saving(id) : Error();
  };
  if (Error error = save_file(*editor_, files_.output, ready, bytes); !error.ok()) return error;
  if (in_place_) {
    if (begin_journal(saved, false).ok()) remove_checkpoint();
  }
  saved_at_ = done_;
  lost_saved_ = false;
  return journal_error_;
}

}  // namespace karst::app
