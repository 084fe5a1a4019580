// SPDX-License-Identifier: MIT
// What is drawn over pictures: places on the screen, words and letters.
#include "app/overlay/overlay_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "app/overlay/font.h"

namespace karst::app {
namespace {

ViewState view_of(int width, int height) {
  ViewState view;
  view.width_px = static_cast<std::uint32_t>(width);
  view.height_px = static_cast<std::uint32_t>(height);
  view.eye = {100, 20, -30};
  EXPECT_TRUE(look_at(view, {110, 18, -50}, {0, 1, 0}));
  set_perspective(view, 60, 0.5, 1000);
  return view;
}

TEST(OverlayText, IsBrokenBetweenWords) {
  const auto joined = [](std::string_view text, std::size_t letters) {
    std::string all;
    for (const std::string_view line : wrap_text(text, letters)) all += std::string(line) + "/";
    return all;
  };
  EXPECT_EQ(joined("dig a hole", 80), "dig a hole/");
  EXPECT_EQ(joined("dig a hole", 5), "dig a/hole/");
  EXPECT_EQ(joined("dig a hole", 9), "dig a/hole/");
  EXPECT_EQ(joined("longword is", 3), "lon/gwo/rd/is/");
  EXPECT_EQ(joined("", 3), "");
  EXPECT_EQ(joined("ab", 0), "a/b/");
}

// Every letter has dots, and no two look alike.
TEST(OverlayText, LettersDiffer) {
  std::array<std::uint8_t, std::size_t{kFontWidth} * kFontHeight> atlas;
  make_font(atlas);
  const auto dots = [&](int c) {
    std::string text;
    for (int y = 0; y < kCellSide; ++y) {
      for (int x = 0; x < kCellSide; ++x) {
        const int at = (c / 16 * kCellSide + y) * kFontWidth + c % 16 * kCellSide + x;
        text += atlas[static_cast<std::size_t>(at)] != 0 ? '#' : '.';
      }
    }
    return text;
  };
  for (int a = '!'; a <= '~'; ++a) {
    EXPECT_NE(dots(a).find('#'), std::string::npos) << a;
    for (int b = '!'; b < a; ++b) EXPECT_NE(dots(a), dots(b)) << static_cast<char>(a) << static_cast<char>(b);
    // A column and more between letters.
    for (int y = 0; y < kCellSide; ++y) EXPECT_EQ(dots(a)[static_cast<std::size_t>(y * kCellSide + 5)], '.');
  }
  EXPECT_EQ(dots(' ').find('#'), std::string::npos);
  EXPECT_EQ(dots(kSolidCell).find('.'), std::string::npos);
}

TEST(OverlayMesh, LinesAreWhereTheViewHasThem) {
  const ViewState view = view_of(640, 360);
  OverlayMesh mesh;
  mesh.start(view, 0);
  const glm::dvec3 places[2] = {{108, 19, -48}, {112, 16, -52}};
  mesh.line(places[0], places[1], {}, 2);
  const std::vector<OverlayVertex> vertices = mesh.lines({});
  ASSERT_EQ(vertices.size(), 6u);
  const auto expect_at = [&](const OverlayVertex& a, const OverlayVertex& b, const glm::dvec3& place) {
    // The middle between the two sides.
    const glm::dvec3 p = place - glm::dvec3(view.eye.x, view.eye.y, view.eye.z);
    double seen[3], clip[4];
    for (int row = 0; row < 3; ++row) {
      seen[row] = view.view_from_world[row] * p.x + view.view_from_world[3 + row] * p.y +
                  view.view_from_world[6 + row] * p.z;
    }
    for (int row = 0; row < 4; ++row) {
      clip[row] = view.clip_from_view[row] * seen[0] + view.clip_from_view[4 + row] * seen[1] +
                  view.clip_from_view[8 + row] * seen[2] + view.clip_from_view[12 + row];
    }
    for (const int axis : {0, 1}) {
      const double middle = (a.clip[axis] / a.clip[3] + b.clip[axis] / b.clip[3]) / 2;
      EXPECT_NEAR(middle, clip[axis] / clip[3], 1e-5);
    }
    // Nearer to the eye than it is.
    EXPECT_LT(a.clip[2] / a.clip[3], clip[2] / clip[3]);
    const double wide = std::hypot((a.clip[0] / a.clip[3] - b.clip[0] / b.clip[3]) * 320,
                                   (a.clip[1] / a.clip[3] - b.clip[1] / b.clip[3]) * 180);
    EXPECT_NEAR(wide, 2, 1e-3);
  };
  expect_at(vertices[0], vertices[1], places[0]);
  expect_at(vertices[2], vertices[5], places[1]);
}

TEST(OverlayMesh, WhatIsBehindTheEyeIsCut) {
  OverlayMesh mesh;
  mesh.start(view_of(640, 360), 0);
  mesh.line({90, 22, -10}, {80, 24, 10}, {});
  EXPECT_EQ(mesh.lines({}).size(), 0u);
  mesh.line({90, 22, -10}, {110, 18, -50}, {});
  mesh.line({110, 18, -50}, {90, 22, -10}, {});
  const std::vector<OverlayVertex> vertices = mesh.lines({});
  ASSERT_EQ(vertices.size(), 12u);
  for (const OverlayVertex& vertex : vertices) EXPECT_GT(vertex.clip[3], 0);
}

// A picture that lies on its side in its target has the words upright on the screen.
TEST(OverlayMesh, TurnsWithThePicture) {
  for (int turns = 0; turns < 4; ++turns) {
    OverlayMesh mesh;
    const bool side = (turns & 1) != 0;
    mesh.start(view_of(side ? 360 : 640, side ? 640 : 360), turns);
    EXPECT_EQ(mesh.size(), glm::ivec2(640, 360));
    mesh.box(0, 0, 64, 36, {});  // top left
    ASSERT_EQ(mesh.screen().size(), 6u);
    const float* const corner = mesh.screen()[0].clip;
    constexpr float kExpected[4][2] = {{-1, 1}, {-1, -1}, {1, -1}, {1, 1}};
    EXPECT_NEAR(corner[0], kExpected[turns][0], 1e-6);
    EXPECT_NEAR(corner[1], kExpected[turns][1], 1e-6);
  }
}

TEST(OverlayMesh, HoldsWhatItSays) {
  OverlayMesh mesh;
  mesh.start(view_of(640, 360), 0);
  for (int n = 0; n < 5000; ++n) mesh.line({108, 19, -48}, {112, 16, -52}, {});
  for (int n = 0; n < 60; ++n) mesh.text(0, 0, 1, "a line of words that goes on", {});
  EXPECT_LE(mesh.screen().size() + mesh.lines({}).size(), OverlayMesh::kMostVertices);
  for (int n = 0; n < 600; ++n) mesh.text(0, 0, 1, "a line of words that goes on", {});
  EXPECT_LE(mesh.screen().size(), OverlayMesh::kMostVertices);
  EXPECT_EQ(mesh.lines({}).size(), 0u);
}

}  // namespace
}  // namespace karst::app
