// SPDX-License-Identifier: MIT
// A world that is edited by hand: what was done is there again after a crash, saved or not, and nobody else
// edits it meanwhile.
#include "app/editor/edit_session.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/edit/journal_file.h"
#include "platform/base/clock.h"
#include "tests/cli/edit/hand_world.h"

namespace karst::app {
namespace {

using test::read_text;

class EditSessionTest : public testing::Test {
 protected:
  void SetUp() override { folder_.write("w.karst", hand_world_file()); }
  std::string world() const { return folder_.path("w.karst"); }
  std::string journal() const { return JournalFile::path_for(world()); }
  bool has_journal() const { return std::filesystem::exists(journal()); }
  std::string bytes(const std::string& name) const { return read_text(folder_.path(name)); }

  test::Folder folder_;
};

// A program with the world open in it.
struct Editing {
  explicit Editing(const EditSession::Files& files) {
    error = session.open(files);
    if (error.ok()) world.emplace(session.base());
    if (error.ok()) error = session.begin(*world->world);
  }
  ~Editing() { session.end(); }

  void stroke(const std::vector<Edit>& edits) {
    session.begin_stroke();
    for (const Edit& edit : edits) {
      EditResult result;
      EXPECT_EQ(session.apply(edit, result).text(), "");
    }
    EXPECT_EQ(session.end_stroke().text(), "");
  }
  void undo(bool expected = true) {
    bool changed = false;
    EXPECT_EQ(session.undo(changed).text(), "");
    EXPECT_EQ(changed, expected);
  }
  void redo(bool expected = true) {
    bool changed = false;
    EXPECT_EQ(session.redo(changed).text(), "");
    EXPECT_EQ(changed, expected);
  }

  std::optional<HandWorld> world;
  EditSession session;
  Error error;
};

const std::vector<Edit> kFirst = {ball(12, 10, 12), ball(14, 10, 12), ball(16, 9, 12)};
const std::vector<Edit> kSecond = {ball(25, 12, 20, 4, EditTool::fill)};
const std::vector<Edit> kThird = {ball(30, 9, 9), ball(30, 7, 12)};

TEST_F(EditSessionTest, WhatWasNotSavedIsThereAgain) {
  {
    Editing first({world(), folder_.path("a.karst")});
    ASSERT_EQ(first.error.text(), "");
    EXPECT_TRUE(first.session.is_saved());
    first.stroke(kFirst);
    first.stroke(kSecond);
    first.stroke(kThird);
    EXPECT_FALSE(first.session.is_saved());
    ASSERT_EQ(first.session.save().text(), "");
  }
  // All is in a.karst: nothing is left of the journal, and the world is what it was.
  EXPECT_FALSE(has_journal());
  EXPECT_TRUE(bytes("w.karst") == read_text(folder_.write("old", hand_world_file())));
  {
    Editing first({world(), ""});
    first.stroke(kFirst);
    first.stroke(kSecond);
    first.stroke(kThird);
  }
  EXPECT_TRUE(has_journal());
  Editing second({world(), folder_.path("b.karst")});
  ASSERT_EQ(second.error.text(), "");
  EXPECT_EQ(second.session.found(), 6u);
  EXPECT_FALSE(second.session.is_saved());
  ASSERT_EQ(second.session.save().text(), "");
  EXPECT_TRUE(bytes("a.karst") == bytes("b.karst"));
}

TEST_F(EditSessionTest, UndoAndRedoAreDoneAgainToo) {
  {
    Editing first({world(), folder_.path("a.karst")});
    first.stroke(kFirst);
    first.stroke(kSecond);
    ASSERT_EQ(first.session.save().text(), "");
  }
  {
    Editing first({world(), ""});
    first.undo(false);
    // A step that changed something, and nothing in all.
    first.stroke({ball(30, 20, 9, 1, EditTool::fill), ball(30, 20, 9, 1)});
    EXPECT_EQ(first.session.undo_steps(), 1u);
    first.undo();
    first.stroke(kFirst);
    first.stroke(kThird);
    first.stroke({ball(30, 9, 9)});  // changes nothing: no step
    EXPECT_EQ(first.session.undo_steps(), 2u);
    first.undo();
    first.undo();
    first.undo(false);
    EXPECT_TRUE(first.session.is_saved());
    first.redo();
    first.redo();
    first.redo(false);
    first.undo();
    first.stroke(kSecond);
    EXPECT_EQ(first.session.redo_steps(), 0u);
    first.redo(false);
  }
  {
    Editing second({world(), folder_.path("b.karst")});
    ASSERT_EQ(second.error.text(), "");
    ASSERT_EQ(second.session.save().text(), "");
    EXPECT_TRUE(bytes("a.karst") == bytes("b.karst"));
    // What was done again can be taken back.
    EXPECT_EQ(second.session.undo_steps(), 2u);
    second.undo();
    EXPECT_FALSE(second.session.is_saved());
    second.redo();
    EXPECT_TRUE(second.session.is_saved());
    second.undo();
    second.undo();
  }
  Editing third({world(), folder_.path("c.karst")});
  ASSERT_EQ(third.session.save().text(), "");
  EXPECT_TRUE(bytes("c.karst") == bytes("w.karst"));
}

TEST_F(EditSessionTest, SavedInPlaceTheJournalBeginsAnew) {
  const auto karst_edit = [&](const std::string& script, const std::string& out) {
    const test::ProcessResult made =
        test::run_process(KARST_APP_PATH, {"edit", world(), "--script", script, "-o", folder_.path(out)});
    ASSERT_EQ(made.code, 0) << made.err;
  };
  std::string left;
  {
    Editing first({world(), ""});
    first.stroke(kFirst);
    first.stroke(kSecond);
    // A journal is a script, whatever its last line was going to be.
    folder_.write("copy.journal", read_text(journal()) + "{\"tool\":\"cle");
    karst_edit(folder_.path("copy.journal"), "script.karst");
    ASSERT_EQ(first.session.save().text(), "");
    EXPECT_TRUE(first.session.is_saved());
    EXPECT_TRUE(bytes("w.karst") == bytes("script.karst"));
    first.stroke(kThird);
    left = read_text(journal());
  }
  Editing second({world(), folder_.path("b.karst")});
  EXPECT_EQ(second.session.found(), 2u);
  ASSERT_EQ(second.session.save().text(), "");
  folder_.write("left.journal", left);
  karst_edit(folder_.path("left.journal"), "script.karst");
  EXPECT_TRUE(bytes("b.karst") == bytes("script.karst"));
}

TEST_F(EditSessionTest, TheSecondEditorIsTold) {
  Editing first({world(), ""});
  ASSERT_EQ(first.error.text(), "");
  Editing second({world(), ""});
  EXPECT_NE(second.error.text().find("is being edited by another karst"), std::string::npos)
      << second.error.text();
  const test::ProcessResult view = test::run_process(
      KARST_APP_PATH, {"view", world(), "--headless", "--edit", "--frames", "1", "--size", "64x36"});
  EXPECT_EQ(view.code, 1);
  EXPECT_NE(view.err.find("is being edited by another karst"), std::string::npos) << view.err;
}

TEST_F(EditSessionTest, WhatWasNotSavedCanBeThrownAway) {
  { Editing({world(), ""}).stroke(kFirst); }
  {
    Editing second({world(), folder_.path("a.karst"), true});
    ASSERT_EQ(second.error.text(), "");
    EXPECT_EQ(second.session.found(), 3u);
    ASSERT_EQ(second.session.save().text(), "");
  }
  EXPECT_FALSE(has_journal());
  EXPECT_TRUE(bytes("a.karst") == bytes("w.karst"));
}

// A world that cannot be loaded, or not be edited, takes nothing from the journal.
TEST_F(EditSessionTest, AJournalThatWasNotDoneAgainStays) {
  { Editing({world(), ""}).stroke(kFirst); }
  const std::string before = read_text(journal());
  {
    EditSession session;
    ASSERT_EQ(session.open({world(), ""}).text(), "");
  }
  EXPECT_EQ(read_text(journal()), before);
}

TEST_F(EditSessionTest, WhatFailsChangesNothingAndIsNotInTheJournal) {
  {
    Editing first({world(), ""});
    first.session.begin_stroke();
    EditResult result;
    Edit wrong = kFirst[0];
    wrong.radius_m = -1;
    EXPECT_NE(first.session.apply(wrong, result).text(), "");
    EXPECT_EQ(first.session.end_stroke().text(), "");
    EXPECT_TRUE(first.session.is_saved());
  }
  EXPECT_FALSE(has_journal());
}

// What was done before a save can be taken back, too; the journal goes on from a file of its own then.
TEST_F(EditSessionTest, UndoGoesBeyondASave) {
  const std::string autosave = folder_.path("w.karst.autosave");
  {
    Editing first({world(), folder_.path("one.karst")});
    first.stroke(kFirst);
    ASSERT_EQ(first.session.save().text(), "");
    first.stroke(kSecond);
    first.session.end();
    std::filesystem::remove(journal());
  }
  {
    Editing first({world(), ""});
    first.stroke(kFirst);
    first.stroke(kSecond);
    ASSERT_EQ(first.session.save().text(), "");
    first.stroke(kThird);
    first.undo();
    EXPECT_TRUE(first.session.is_saved());
    EXPECT_FALSE(std::filesystem::exists(autosave));
    first.undo();
    EXPECT_FALSE(first.session.is_saved());
    EXPECT_TRUE(std::filesystem::exists(autosave));
    first.redo();
    EXPECT_TRUE(first.session.is_saved());
    first.redo();
    first.undo();
    EXPECT_TRUE(first.session.is_saved());
    EXPECT_TRUE(read_text(autosave) == bytes("w.karst"));
    first.undo();
    EXPECT_TRUE(read_text(autosave) == bytes("one.karst"));
  }
  {
    // As it was after the first stroke; and what comes on top is in the journal.
    Editing second({world(), folder_.path("a.karst")});
    ASSERT_EQ(second.error.text(), "");
    EXPECT_EQ(second.session.base(), autosave);
    EXPECT_FALSE(second.session.is_saved());
    ASSERT_EQ(second.session.save().text(), "");
    EXPECT_TRUE(bytes("a.karst") == bytes("one.karst"));
    second.stroke(kThird);
  }
  std::string third;
  {
    Editing again({world(), ""});
    ASSERT_EQ(again.error.text(), "");
    EXPECT_EQ(again.session.found(), 3u);
    ASSERT_EQ(again.session.save().text(), "");
    EXPECT_FALSE(std::filesystem::exists(autosave));
    third = bytes("w.karst");
  }
  EXPECT_FALSE(has_journal());
  folder_.write("w.karst", hand_world_file());
  Editing whole({world(), folder_.path("b.karst")});
  EXPECT_EQ(whole.session.found(), 0u);
  whole.stroke(kFirst);
  whole.stroke(kThird);
  ASSERT_EQ(whole.session.save().text(), "");
  EXPECT_TRUE(bytes("b.karst") == third);
}

// --- kills

// Stroke n of a world that is edited without an end: of one to three edits, each where n says.
std::vector<Edit> stroke_of(int n) {
  std::vector<Edit> edits;
  for (int k = 0; k <= n % 3; ++k) {
    const auto hash = test::mix(static_cast<std::uint64_t>(n * 4 + k));
    const auto at = [&](int shift, int size) {
      return static_cast<double>(hash >> shift & 0xff) / 256 * size;
    };
    edits.push_back(ball(at(0, 40), at(8, 16), at(16, 36), 1.5 + at(24, 2),
                         (hash >> 40 & 1) != 0 ? EditTool::fill : EditTool::clear));
  }
  return edits;
}

// Each fifth step takes back what was done last.
void do_step(Editing& editing, int n, std::size_t most_edits) {
  if (n % 5 == 3) {
    bool changed = false;
    if (most_edits > 0 && !editing.session.undo(changed).ok()) _exit(8);
    return;
  }
  const std::vector<Edit> edits = stroke_of(n);
  editing.session.begin_stroke();
  for (std::size_t k = 0; k < std::min(most_edits, edits.size()); ++k) {
    EditResult result;
    if (!editing.session.apply(edits[k], result).ok()) _exit(4);
  }
  if (!editing.session.end_stroke().ok()) _exit(5);
}

// Tells its number when a step has ended; saves in place after every third.
void edit_for_ever(const std::string& world, int out) {
  Editing editing({world, ""});
  if (!editing.error.ok()) _exit(3);
  for (int n = 0;; ++n) {
    do_step(editing, n, SIZE_MAX);
    if (write(out, &n, sizeof n) != sizeof n) _exit(6);
    if (n % 3 == 2 && !editing.session.save().ok()) _exit(7);
  }
}

// Killed at any moment, the next editor has all steps that had ended, and at most a part of one more; and
// the world with them is, to the bit, what it is where nobody was killed.
TEST_F(EditSessionTest, KilledItLosesAtMostTheStrokeInHand) {
  const char* const given = std::getenv("KARST_KILLS");
  const int kills = given == nullptr ? 8 : std::atoi(given);
  // After so many steps and so many edits of the next.
  std::map<std::pair<int, std::size_t>, std::string> known;
  const auto expected = [&](int ended, std::size_t edits) -> const std::string& {
    std::string& bytes_then = known[{ended, edits}];
    if (!bytes_then.empty()) return bytes_then;
    Editing editing({folder_.write("p.karst", hand_world_file()), folder_.path("expected.karst"), true});
    for (int k = 0; k < ended; ++k) do_step(editing, k, SIZE_MAX);
    do_step(editing, ended, edits);
    EXPECT_EQ(editing.session.save().text(), "");
    return bytes_then = bytes("expected.karst");
  };
  test::Random random{7};
  double step_us = 20'000;  // of the last child's
  int in_stroke = 0, steps = 0, autosaves = 0;
  for (int kill_n = 0; kill_n < kills; ++kill_n) {
    folder_.write("w.karst", hand_world_file());
    std::filesystem::remove(journal());
    std::filesystem::remove(folder_.path("w.karst.autosave"));
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      close(ends[0]);
      edit_for_ever(world(), ends[1]);
    }
    close(ends[1]);
    int ended = 0, n = 0;  // steps
    std::int64_t began = 0;
    for (const int wait = 1 + random.below(9); ended < wait && read(ends[0], &n, sizeof n) == sizeof n;) {
      ended = n + 1;
      if (began == 0) began = now_ns();
    }
    if (ended > 1) step_us = static_cast<double>(now_ns() - began) * 1e-3 / (ended - 1);
    usleep(static_cast<useconds_t>(2 * step_us * random.unit()));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << WEXITSTATUS(status);
    while (read(ends[0], &n, sizeof n) == sizeof n) ended = n + 1;
    close(ends[0]);
    steps += ended;
    {
      Editing found({world(), folder_.path("found.karst")});
      ASSERT_EQ(found.error.text(), "");
      autosaves += found.session.base() != world();
      ASSERT_EQ(found.session.save().text(), "");
    }
    bool same = false;
    for (std::size_t edits = 0; edits <= 3 && !same; ++edits) {
      same = expected(ended, edits) == bytes("found.karst");
      in_stroke += same && edits > 0;
    }
    ASSERT_TRUE(same) << "kill " << kill_n << " after " << ended << " steps";
  }
  std::printf(
      "%d kills: %d steps had ended; %d times a part or all of one more was there, %d times the world "
      "of an undo beyond a save\n",
      kills, steps, in_stroke, autosaves);
  EXPECT_GE(steps, kills);
}

}  // namespace
}  // namespace karst::app
