// SPDX-License-Identifier: MIT
// Which mode a request means, and what is tried in which order.
#include "platform/kms/kms_mode.h"

#include <gtest/gtest.h>

namespace karst::core {
namespace {

drmModeModeInfo mode(int width, int height, double hz, bool preferred = false, unsigned flags = 0) {
  drmModeModeInfo m{};
  m.hdisplay = static_cast<std::uint16_t>(width);
  m.vdisplay = static_cast<std::uint16_t>(height);
  m.htotal = 1000;
  m.vtotal = 1000;
  m.clock = static_cast<std::uint32_t>(hz * 1000 + 0.5);  // kHz: of 10^6 pixels
  m.flags = flags;
  m.type = preferred ? DRM_MODE_TYPE_PREFERRED : 0;
  return m;
}

const std::vector<drmModeModeInfo> kModes = {mode(1920, 1080, 60),      mode(1920, 1080, 59.94),
                                             mode(1280, 720, 60, true), mode(3840, 2160, 30),
                                             mode(3840, 2160, 60),      mode(640, 480, 60)};

std::size_t choose(const char* text) {
  ModeRequest request;
  EXPECT_EQ(parse_mode(text, "--mode", request).text(), "");
  return choose_mode(kModes, request);
}

TEST(KmsMode, ARequestMeansOneMode) {
  EXPECT_EQ(choose("preferred"), 2u);
  EXPECT_EQ(choose("highest"), 4u);
  EXPECT_EQ(choose("1920x1080"), 0u);
  EXPECT_EQ(choose("1920x1080@59.94"), 1u);
  EXPECT_EQ(choose("1920x1080@59.9"), 1u);
  EXPECT_EQ(choose("1920x1080@60"), 0u);
  EXPECT_EQ(choose("3840x2160@60"), 4u);
  EXPECT_EQ(choose("1920x1080@50"), kNoMode);
  EXPECT_EQ(choose("800x600"), kNoMode);
  EXPECT_EQ(choose_mode({}, {}), kNoMode);
}

TEST(KmsMode, WithoutAPreferredModeTheFirstIs) {
  const std::vector<drmModeModeInfo> modes = {mode(0, 0, 60), mode(640, 480, 60), mode(800, 600, 60)};
  EXPECT_EQ(choose_mode(modes, {}), 1u);
}

TEST(KmsMode, WrongRequestsAreTold) {
  ModeRequest request;
  for (const char* text : {"", "big", "1920", "1920x", "x1080", "0x1", "1x99999", "1x1@", "1x1@0", "1x1@60Hz",
                           "1x1@1e9", "-1x1"}) {
    EXPECT_NE(parse_mode(text, "--mode", request).text().find("--mode: '"), std::string::npos) << text;
  }
}

TEST(KmsMode, RefreshCountsFields) {
  EXPECT_DOUBLE_EQ(refresh_hz(mode(1, 1, 60)), 60);
  EXPECT_DOUBLE_EQ(refresh_hz(mode(1, 1, 30, false, DRM_MODE_FLAG_INTERLACE)), 60);
  EXPECT_DOUBLE_EQ(refresh_hz(mode(1, 1, 60, false, DRM_MODE_FLAG_DBLSCAN)), 30);
  drmModeModeInfo unknown{};
  unknown.vrefresh = 50;
  EXPECT_DOUBLE_EQ(refresh_hz(unknown), 50);
}

TEST(KmsMode, AttemptsGoFromBestToLeast) {
  std::string order;
  for (const KmsAttempt& attempt : plan_attempts(kModes, 0, {}))
    order += attempt_text(attempt, kModes) + "\n";
  EXPECT_EQ(order,
            "1920x1080@60.00, atomic with modifiers\n"
            "1920x1080@60.00, atomic without modifiers\n"
            "1280x720@60.00, atomic without modifiers\n"
            "640x480@60.00, atomic without modifiers\n"
            "1920x1080@60.00, legacy\n"
            "1280x720@60.00, legacy\n"
            "640x480@60.00, legacy\n");
  EXPECT_EQ(plan_attempts(kModes, 0, {true, false, false, false}).size(), 1u);
  EXPECT_TRUE(plan_attempts(kModes, 0, {false, false, true, true}).empty());
}

}  // namespace
}  // namespace karst::core
