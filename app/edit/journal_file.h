// SPDX-License-Identifier: MIT
// What was done to a world since it was saved, kept beside it while it is edited: WORLD.journal. Each step is
// a line (edit_script.h) that is on the disk before append() or sync() returns, with a checksum of its own;
// so a crash loses what was not appended, and nothing else. The first line says which world it is of.
//
//   JournalFile journal;  std::vector<ScriptStep> lost;
//   journal.open(path_of_world, id_of_world, lost)   // locked: a second editor is told
//   journal.append(step) ...
//   journal.saving(id_of_new)  before the new world takes the old one's place
//   journal.begin_anew(id_of_new)  after it
//   journal.close()            // nothing was done since the last save: the file is removed
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "app/edit/edit_script.h"
#include "platform/base/error.h"

namespace karst::app {

// Of a world file's first kWorldIdBytes, which hold the checksums of all others. FNV-1a (Fowler, Noll, Vo).
inline constexpr std::size_t kWorldIdBytes = 1024;
std::uint64_t world_id(std::span<const std::byte> first_bytes);

class JournalFile {
 public:
  JournalFile() = default;
  JournalFile(const JournalFile&) = delete;
  JournalFile& operator=(const JournalFile&) = delete;
  ~JournalFile();

  static std::string path_for(const std::string& world) { return world + ".journal"; }

  // steps: what an earlier editor that did not end had done to this very world, to be done again; a line that
  // it was writing is left out. The error says so where another one is editing, where the journal is of
  // another state of the world, or where a line in its middle is damaged; then the file is left as it is.
  // other: the id of a file in whose place the world's own may stand; 0: there is none.
  Error open(const std::string& world, std::uint64_t id, std::vector<ScriptStep>& steps,
             std::uint64_t other = 0);
  // The steps are of that other file.
  bool is_of_other() const { return of_other_; }
  bool is_open() const { return file_ >= 0; }
  // The number of steps that it has.
  std::size_t steps() const { return steps_; }

  // on_disk false: as far as this program is concerned; sync() puts it onto the disk.
  Error append(const ScriptStep& step, bool on_disk = true);
  Error sync();
  // What is about to be saved holds all of it: found again with either id, the journal means the right thing.
  Error saving(std::uint64_t id);
  // is_other: the id is that of the other file.
  Error begin_anew(std::uint64_t id, bool is_other = false);
  // close() keeps a journal that has steps, or one of another file; remove() none: what it has is saved.
  void close();
  void remove();

 private:
  Error put_line(std::string line, bool on_disk);

  std::string path_;
  int file_ = -1;
  std::size_t steps_ = 0;
  bool of_other_ = false;
};

// Tells where a program is editing the world, whose file is going to be replaced.
Error check_not_edited(const std::string& world);

}  // namespace karst::app
