// SPDX-License-Identifier: MIT
#include "tests/device/run/plan.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/support/process.h"

namespace karst::device {
namespace {

using Words = std::vector<std::string>;

std::string error_of(const std::string& text) {
  std::vector<Part> parts;
  return parse_plan(text, "a.plan", parts).text();
}

TEST(Plan, RefusesWhatItCannotRun) {
  EXPECT_EQ(error_of(""), "a.plan: has no parts");
  EXPECT_EQ(error_of("# nothing\n\n"), "a.plan: has no parts");
  EXPECT_EQ(error_of("tests gl : a\nframes b c\n"), "a.plan, line 2: not of the form KIND NAME : WORDS");
  EXPECT_EQ(error_of("frames b :\n"), "a.plan, line 1: not of the form KIND NAME : WORDS");
  EXPECT_EQ(error_of("test gl : a\n"), "a.plan, line 1: 'test' is no kind of part");
  EXPECT_EQ(error_of("frames a : b\nframes a : c\n"), "a.plan, line 2: there is another frames 'a'");
}

TEST(Plan, TakesAPartALine) {
  std::vector<Part> parts;
  const Error error =
      parse_plan("# a way\nframes  low : canyon --size 64x36  # small\ntests low : x", "", parts);
  ASSERT_TRUE(error.ok()) << error.text();
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].kind, PartKind::frames);
  EXPECT_EQ(parts[0].name, "low");
  EXPECT_EQ(parts[0].words, (Words{"canyon", "--size", "64x36"}));
  EXPECT_EQ(parts[1].kind, PartKind::tests);
}

TEST(Plan, ThoseOfTheFolderAreGood) {
  for (const char* name : {"full", "quick"}) {
    const std::string path = std::string(KARST_SOURCE_DIR "/tests/device/folder/") + name + ".plan";
    std::vector<Part> parts;
    const Error error = parse_plan(test::read_text(path), path, parts);
    EXPECT_TRUE(error.ok()) << error.text();
  }
}

}  // namespace
}  // namespace karst::device
