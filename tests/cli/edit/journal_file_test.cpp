// SPDX-License-Identifier: MIT
#include "app/edit/journal_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace karst::app {
namespace {

ScriptStep step_at(double x) {
  ScriptStep step;
  step.what.place = step.what.to = {x, 2, 3};
  return step;
}

class JournalFileTest : public testing::Test {
 protected:
  std::string world() const {
    return testing::TempDir() + "karst_" + testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  std::string path() const { return JournalFile::path_for(world()); }
  void SetUp() override { std::filesystem::remove(path()); }
  void TearDown() override { std::filesystem::remove(path()); }

  std::string text() const {
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void put(const std::string& text) const { std::ofstream(path(), std::ios::binary) << text; }
  // Steps that an editor of the world finds; the error where it finds none.
  std::string found(std::uint64_t id, std::vector<ScriptStep>& steps) const {
    JournalFile journal;
    return journal.open(world(), id, steps).text();
  }
};

TEST_F(JournalFileTest, EveryCutIsALineLostAtMost) {
  std::vector<ScriptStep> steps;
  {
    JournalFile journal;
    ASSERT_EQ(journal.open(world(), 7, steps).text(), "");
    for (int n = 0; n < 5; ++n) ASSERT_EQ(journal.append(step_at(n)).text(), "");
  }
  const std::string whole = text();
  std::vector<std::size_t> ends;  // of lines
  for (std::size_t at = 0; at < whole.size(); ++at) {
    if (whole[at] == '\n') ends.push_back(at + 1);
  }
  ASSERT_EQ(ends.size(), 6u);
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    put(whole.substr(0, cut));
    std::size_t lines = 0;
    while (lines < ends.size() && ends[lines] <= cut) ++lines;
    ASSERT_EQ(found(7, steps), "") << cut;
    ASSERT_EQ(steps.size(), lines == 0 ? 0 : lines - 1) << cut;
    for (std::size_t n = 0; n < steps.size(); ++n) ASSERT_EQ(steps[n].what.place.x, static_cast<double>(n));
    // What was half a line is gone, and more can be written.
    JournalFile journal;
    ASSERT_EQ(journal.open(world(), 7, steps).text(), "");
    ASSERT_EQ(journal.append(step_at(9)).text(), "");
    ASSERT_EQ(journal.steps(), steps.size() + 1);
  }
  // Zeros where power failed.
  put(whole.substr(0, ends[3]) + std::string(700, '\0'));
  EXPECT_EQ(found(7, steps), "");
  EXPECT_EQ(steps.size(), 3u);
}

TEST_F(JournalFileTest, ADamagedMiddleIsToldAndKept) {
  std::vector<ScriptStep> steps;
  {
    JournalFile journal;
    ASSERT_EQ(journal.open(world(), 7, steps).text(), "");
    for (int n = 0; n < 3; ++n) ASSERT_EQ(journal.append(step_at(n)).text(), "");
  }
  std::string damaged = text();
  const std::size_t at = damaged.find("[1,");
  damaged[at + 1] = '8';
  put(damaged);
  EXPECT_EQ(found(7, steps), path() +
                                 ": line 3: damaged, and lines follow: what they did cannot be done "
                                 "again; move the journal away to edit the world as it was saved");
  EXPECT_EQ(text(), damaged);
}

TEST_F(JournalFileTest, ASecondEditorIsTold) {
  std::vector<ScriptStep> steps;
  JournalFile first;
  ASSERT_EQ(first.open(world(), 7, steps).text(), "");
  EXPECT_EQ(found(7, steps), world() + ": is being edited by another karst");
  first.close();
  EXPECT_FALSE(std::filesystem::exists(path()));  // nothing was done
  EXPECT_EQ(found(7, steps), "");
}

TEST_F(JournalFileTest, SavingIsOneMoment) {
  std::vector<ScriptStep> steps;
  const auto edited = [&] {
    JournalFile journal;
    EXPECT_EQ(journal.open(world(), 7, steps).text(), "");
    EXPECT_EQ(journal.append(step_at(1)).text(), "");
    EXPECT_EQ(journal.saving(8).text(), "");
  };
  edited();
  // The new world did not take its place: what was done is to be done again.
  EXPECT_EQ(found(7, steps), "");
  EXPECT_EQ(steps.size(), 1u);
  std::filesystem::remove(path());
  edited();
  // It did: nothing is.
  EXPECT_EQ(found(8, steps), "");
  EXPECT_TRUE(steps.empty());
  std::filesystem::remove(path());
  edited();
  // A third world: nobody knows.
  EXPECT_EQ(found(9, steps), path() + ": holds edits of another state of " + world() +
                                 "; move it away, or put that world back, to go on");
  // Saving failed and the editor went on: the old world it is.
  {
    JournalFile journal;
    ASSERT_EQ(journal.open(world(), 7, steps).text(), "");
    ASSERT_EQ(journal.append(step_at(2)).text(), "");
  }
  EXPECT_NE(found(8, steps), "");
  EXPECT_EQ(found(7, steps), "");
  EXPECT_EQ(steps.size(), 2u);
}

TEST_F(JournalFileTest, AJournalIsAScript) {
  std::vector<ScriptStep> steps;
  {
    JournalFile journal;
    ASSERT_EQ(journal.open(world(), 7, steps).text(), "");
    ASSERT_EQ(journal.append(step_at(1)).text(), "");
    ASSERT_EQ(journal.append({ScriptStep::undo, false, {}}).text(), "");
    ASSERT_EQ(journal.saving(8).text(), "");
  }
  ASSERT_EQ(parse_script(text(), "journal", steps).text(), "");
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[1].kind, ScriptStep::undo);
}

TEST_F(JournalFileTest, WhatIsNoJournalIsLeftAlone) {
  std::vector<ScriptStep> steps;
  std::filesystem::create_symlink("/dev/null", path());
  EXPECT_NE(found(7, steps), "");
  std::filesystem::remove(path());
  ASSERT_EQ(mkfifo(path().c_str(), 0600), 0);
  EXPECT_EQ(found(7, steps), path() + ": cannot be a journal: not a regular file");
}

}  // namespace
}  // namespace karst::app
