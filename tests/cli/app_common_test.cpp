// SPDX-License-Identifier: MIT
// What both programs share, where running a program would not show it.
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "app/common/arguments.h"
#include "app/common/camera_path.h"
#include "app/common/json_writer.h"
#include "app/files/atomic_file.h"
#include "app/files/output_place.h"
#include "app/files/png_file.h"
#include "app/files/whole_file.h"
#include "boards/board_profile.h"
#include "platform/base/text.h"
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

TEST(JsonWriter, TextIsUtf8WhateverItWas) {
  JsonWriter json;
  json.value(std::string_view("a\xC3\xA9\xFF\xC2\x9B\xE2\x80\xAE\"\n"));
  EXPECT_EQ(json.text(), "\"a\xC3\xA9\\ufffd\\u009b\\u202e\\\"\\u000a\"");
}

TEST(Text, CharactersAreThoseOfRfc3629) {
  char32_t code = 0;
  EXPECT_EQ(utf8_character("\xF0\x9F\x8F\x94x", code), 4u);
  EXPECT_EQ(code, 0x1F3D4u);
  // Cut, a lone continuation, too long for what it says, half of a pair, beyond the last.
  for (const char* bad :
       {"", "\xC3", "\x80", "\xC0\x80", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"}) {
    EXPECT_EQ(utf8_character(bad, code), 0u) << bad;
  }
}

TEST(Text, NothingThatATerminalObeysIsPrinted) {
  EXPECT_EQ(printable("H\xC3\xBCgel 5 m"), "H\xC3\xBCgel 5 m");
  // ESC, DEL, CSI of C1 in UTF-8 and as a byte, right-to-left override, end of line.
  EXPECT_EQ(printable("a\x1b[2J\x7f\xC2\x9B\x9B\xE2\x80\xAE\n"), "a?[2J?????");
}

TEST(Text, QuotesAreCutBetweenCharacters) {
  EXPECT_EQ(quote("a \xC3\xA9"), "'a \xC3\xA9'");
  EXPECT_EQ(excerpt(std::string(80, 'x')), std::string(80, 'x'));
  EXPECT_EQ(excerpt(std::string(81, 'x')), std::string(80, 'x') + "...");
  // The 80th byte is inside of a character of two, three and four bytes.
  for (const char* character : {"\xC3\xA9", "\xE2\x82\xAC", "\xF0\x9F\x8F\x94"}) {
    const std::string before(79, 'x');
    EXPECT_EQ(excerpt(before + character + "y"), before + "...");
  }
  EXPECT_EQ(excerpt(std::string(81, '\xFF')), std::string(80, '\xFF') + "...") << "no UTF-8 counts by bytes";
}

// However long a user's text is, the line that it is quoted in stays short.
TEST(Text, MessagesQuoteAPartOfLongText) {
  const std::string text(5'000, 'q'), seven = std::string(5'000, '0') + "7";
  double value = 0;
  std::int64_t whole = 0;
  int width = 0, height = 0;
  CameraPlace place;
  std::vector<CameraPlace> path;
  BoardProfile board;
  const Error errors[] = {parse_number(text, "--fov", 0, 1, value),
                          parse_number(seven, "--fov", 0, 1, value),
                          parse_integer(text, "--level", 0, 1, whole),
                          parse_integer(seven, "--level", 0, 1, whole),
                          parse_size(text, "--size", 9, width, height),
                          parse_size(text + "x1", "--size", 9, width, height),
                          parse_camera(text, "--camera", place),
                          parse_camera_path(text, "path.txt", path),
                          parse_board(text + " = 1 # r", "a.board", board),
                          find_board(text, board)};
  for (const Error& error : errors) {
    EXPECT_FALSE(error.ok());
    EXPECT_LT(error.text().size(), 300u) << error.text();
  }
}

TEST(Png, LargePicturesAreRefusedBeforeTheyAreRead) {
  std::vector<std::byte> png;
  ASSERT_TRUE(encode_png(std::vector<std::uint8_t>(64 * 32 * 4), 64, 32, png).ok());
  PngPicture picture;
  EXPECT_TRUE(decode_png(png, 64, 64 * 32 * 4, picture).ok());
  EXPECT_NE(decode_png(png, 64, 64 * 32 * 4 - 1, picture).text().find("64 x 32 pixels, which take"),
            std::string::npos);
  EXPECT_NE(decode_png(png, 63, 1 << 20, picture).text().find("more than 63 a side"), std::string::npos);
  EXPECT_TRUE(picture.rgba.empty());
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
  WholeFile file;
  EXPECT_EQ(file.open(folder.path("a"), WholeFile::kMostText).text(), "");
  EXPECT_EQ(file.bytes().size(), text.size());
}

// Another file is renamed into its place: its mode would be the new one's.
TEST(AtomicFile, ReplacedFilesKeepTheirRights) {
  const test::Folder folder;
  const std::string path = folder.write("a", std::string("old"));
  for (const mode_t mode : {0600u, 0664u}) {
    ASSERT_EQ(chmod(path.c_str(), mode), 0);
    EXPECT_EQ(write_file_atomic(path, {}).text(), "");
    struct stat info {};
    ASSERT_EQ(stat(path.c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777u, mode);
  }
}

TEST(AtomicFile, LongNamesAreLegal) {
  const test::Folder folder;
  for (const std::size_t length : {251u, 255u}) {
    const std::string path = folder.path(std::string(length, 'x'));
    EXPECT_EQ(check_writable(path).text(), "");
    EXPECT_EQ(write_file_atomic(path, {}).text(), "");
  }
  EXPECT_EQ(folder.names().size(), 2u);
  EXPECT_NE(check_writable(folder.path(std::string(256, 'x'))).text(), "");
}

TEST(AtomicFile, LinksOfOnesOwnAreFollowed) {
  const test::Folder folder;
  ASSERT_EQ(symlink("new", folder.path("to_new").c_str()), 0);
  ASSERT_EQ(symlink("to_new", folder.path("twice").c_str()), 0);
  ASSERT_EQ(symlink("round", folder.path("round").c_str()), 0);
  const std::string text = "karst";
  EXPECT_EQ(write_file_atomic(folder.path("twice"), std::as_bytes(std::span(text))).text(), "");
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"new", "round", "to_new", "twice"}));
  EXPECT_EQ(test::read_text(folder.path("new")), text);
  EXPECT_TRUE(std::filesystem::is_symlink(folder.path("twice")));
  EXPECT_NE(check_writable(folder.path("round")).text(), "");
}

TEST(AtomicFile, LinksOfOthersAreRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can give a link to somebody else";
  const test::Folder folder;
  const std::string target = folder.write("target", std::string("theirs"));
  ASSERT_EQ(symlink("target", folder.path("link").c_str()), 0);
  ASSERT_EQ(lchown(folder.path("link").c_str(), 12'345, 12'345), 0);
  for (const Error& error : {check_writable(folder.path("link")), write_file_atomic(folder.path("link"), {})})
    EXPECT_NE(error.text().find("symbolic link of another user"), std::string::npos) << error.text();
  EXPECT_EQ(test::read_text(target), "theirs");
}

TEST(AtomicFile, WhatKilledProcessesLeftIsSwept) {
  const test::Folder folder;
  folder.write(".karst-1-0.tmp", std::string("left"));
  const std::string busy = folder.write(".karst-2-0.tmp", std::string("being written"));
  folder.write("karst-3-0.tmp", std::string("of the user"));
  const int writer = open(busy.c_str(), O_WRONLY | O_CLOEXEC);
  ASSERT_EQ(flock(writer, LOCK_EX), 0);
  EXPECT_EQ(check_writable(folder.path("a")).text(), "");
  EXPECT_EQ(folder.names(), (std::vector<std::string>{".karst-2-0.tmp", "karst-3-0.tmp"}));
  close(writer);
}

// A child that writes again and again is ended in between.
TEST(AtomicFile, SignalsLeaveTheOldFileAndNoOther) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    const test::Folder folder;
    const std::string path = folder.write("a", std::string("old"));
    const std::vector<std::byte> bytes(64 << 20);
    const pid_t child = fork();
    if (child == 0) {
      for (;;) {
        if (!write_file_atomic(folder.path("b"), bytes).ok()) _exit(1);
      }
    }
    // Until it writes, and then a while, so that signals come everywhere.
    while (folder.names().size() < 2) usleep(1000);
    usleep(20'000);
    kill(child, number);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << status;
    for (const std::string& name : folder.names()) EXPECT_TRUE(name == "a" || name == "b") << name;
    EXPECT_EQ(test::read_text(path), "old");
  }
}

TEST(OutputPlace, OutputsMayNotBeInputsOrEachOther) {
  const test::Folder folder;
  const std::string a = folder.write("a", std::string("a"));
  ASSERT_EQ(link(a.c_str(), folder.path("hard").c_str()), 0);
  ASSERT_EQ(symlink("a", folder.path("soft").c_str()), 0);
  ASSERT_EQ(symlink("new", folder.path("soft_new").c_str()), 0);
  const auto said = [&](const std::string& output, const std::string& other, bool is_input) {
    const NamedFile out[] = {{"-o", output}, {"--stats", other}};
    const NamedFile in{"WORLD", other};
    return is_input ? check_outputs_apart(std::span(out).first(1), {&in, 1}).text()
                    : check_outputs_apart(out, {}).text();
  };
  for (const char* same : {"a", "./a", "hard", "soft"}) {
    EXPECT_EQ(said(folder.path(same), a, true),
              "-o: " + folder.path(same) + " is also WORLD; name another file");
    EXPECT_NE(said(folder.path(same), a, false), "") << same;
  }
  EXPECT_NE(said(folder.path("new"), folder.path("./new"), false), "");
  EXPECT_NE(said(folder.path("new"), folder.path("soft_new"), false), "");
  EXPECT_EQ(said(folder.path("new"), folder.path("other"), false), "");
  EXPECT_EQ(said(a, folder.path("other"), true), "");
  EXPECT_EQ(said("/dev/null", "/dev/null", false), "");
  EXPECT_EQ(said("-", "-", false), "");
}

TEST(WholeFile, KeepsWhatItReadAndKnowsItsLimit) {
  const test::Folder folder;
  const std::string path = folder.write("a", std::string(100'000, 'x'));
  WholeFile file;
  EXPECT_NE(file.open(path, 99'999).text().find("100000 bytes, more than the 99999"), std::string::npos);
  ASSERT_EQ(file.open(path, 100'000).text(), "");
  ASSERT_EQ(truncate(path.c_str(), 1), 0);  // a mapped file ends the program here
  EXPECT_EQ(file.text(), std::string(100'000, 'x'));
}

TEST(AtomicFile, CheckingLeavesNothing) {
  const test::Folder folder;
  EXPECT_EQ(check_writable(folder.path("a")).text(), "");
  EXPECT_EQ(check_writable("").text(), "output file name is empty");
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace karst::app
