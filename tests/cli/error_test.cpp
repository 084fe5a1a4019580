// SPDX-License-Identifier: MIT
// Error: what a Status becomes in a line for the user.
#include "platform/base/error.h"

#include <gtest/gtest.h>

namespace karst {
namespace {

TEST(ErrorTest, NothingIsNoError) {
  EXPECT_TRUE(Error().ok());
  EXPECT_EQ(Error().text(), "");
  EXPECT_TRUE(Error("a.karst", Status()).ok());
  EXPECT_EQ(Error("a.karst", Status()).text(), "");
}

TEST(ErrorTest, HoldsItsLine) {
  const Error error = "a.karst: cannot be opened";
  EXPECT_FALSE(error.ok());
  EXPECT_EQ(error.text(), "a.karst: cannot be opened");
}

TEST(ErrorTest, StatusNamesSubjectFieldAndValue) {
  const auto text = [](StatusCode code, const char* field, std::uint64_t value) {
    const Error error("a.karst", Status(code, "is wrong", field, value));
    EXPECT_FALSE(error.ok());
    return error.text();
  };
  EXPECT_EQ(text(StatusCode::corrupt, "header", 28), "a.karst: is wrong (header, at byte 28)");
  EXPECT_EQ(text(StatusCode::corrupt, "header", 0), "a.karst: is wrong (header)");
  EXPECT_EQ(text(StatusCode::unsupported, "version", 8), "a.karst: is wrong (version, at byte 8)");
  EXPECT_EQ(text(StatusCode::io, "file", 64), "a.karst: is wrong (file, at byte 64)");
  EXPECT_EQ(text(StatusCode::limit_reached, "patches", 900), "a.karst: is wrong (patches: 900)");
  EXPECT_EQ(text(StatusCode::invalid_argument, "level", 7), "a.karst: is wrong (level)");
  EXPECT_EQ(text(StatusCode::invalid_argument, "", 0), "a.karst: is wrong");
}

}  // namespace
}  // namespace karst
