// SPDX-License-Identifier: MIT
// What both programs share, where running a program would not show it.
#include <sys/stat.h>

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "app/common/arguments.h"
#include "app/common/json_writer.h"
#include "app/files/atomic_file.h"
#include "app/files/mapped_file.h"
#include "tests/support/process.h"

namespace karst::app {
namespace {

TEST(JsonWriter, WritesEveryKindOfValue) {
  JsonWriter json;
  json.begin_object().field("text", "a\"b\\c\n").field("yes", true).field("pi", 3.25).field("n", -7);
  json.field("big", std::uint64_t{18446744073709551615u}).field("nan", std::nan("")).field("inf", INFINITY);
  json.key("list").begin_array().value(1).begin_array().end_array().null().end_array();
  json.key("none").begin_object().end_object().end_object();
  EXPECT_EQ(json.text(), R"({
  "text": "a\"b\\c\u000a",
  "yes": true,
  "pi": 3.25,
  "n": -7,
  "big": 18446744073709551615,
  "nan": null,
  "inf": null,
  "list": [
    1,
    [],
    null
  ],
  "none": {}
}
)");
}

TEST(JsonWriter, NumbersReadBackAsTheyWere) {
  for (const double number : {0.1, 1e-300, 123456789.123456789, -2.5e17}) {
    JsonWriter json;
    json.begin_array().value(number).end_array();
    EXPECT_EQ(std::stod(json.text().substr(json.text().find_first_of("-0123456789"))), number);
  }
}

TEST(Arguments, NumbersAreWholeWords) {
  double number = 0;
  EXPECT_EQ(parse_number("+2.5", "x", 0, 10, number).text(), "");
  EXPECT_EQ(number, 2.5);
  for (const char* text : {"", "2.5m", " 2", "0x10", "nan", "+-2", "1e999"}) {
    EXPECT_NE(parse_number(text, "x", -1e308, 1e308, number).text(), "") << text;
  }
  EXPECT_EQ(number, 2.5) << "left alone by errors";
  std::int64_t whole = 0;
  for (const char* text : {"", "1.0", "99999999999999999999", "4"}) {
    EXPECT_NE(parse_integer(text, "x", 0, 3, whole).text(), "") << text;
  }
  EXPECT_EQ(parse_integer("3", "x", 0, 3, whole).text(), "");
}

TEST(AtomicFile, NewFilesHaveTheUsualRights) {
  const test::Folder folder;
  const mode_t before = umask(027);
  const std::string text = "karst";
  EXPECT_EQ(write_file_atomic(folder.path("a"), std::as_bytes(std::span(text))).text(), "");
  umask(before);
  struct stat info {};
  ASSERT_EQ(stat(folder.path("a").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777u, 0640u);
  MappedFile file;
  EXPECT_EQ(file.open(folder.path("a")).text(), "");
  EXPECT_EQ(file.bytes().size(), text.size());
}

TEST(AtomicFile, CheckingLeavesNothing) {
  const test::Folder folder;
  EXPECT_EQ(check_writable(folder.path("a")).text(), "");
  EXPECT_EQ(check_writable("").text(), "output file name is empty");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace karst::app
