// SPDX-License-Identifier: MIT
// Keys, mouse and fingers as movements of the camera.
#include "app/motion/navigator.h"

#include <linux/input-event-codes.h>

#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

namespace karst::app {
namespace {

using Kind = InputEvent::Kind;

InputEvent key(unsigned code, bool pressed = true) {
  return {Kind::key, pressed, 0, code, 0, 0};
}
InputEvent finger(int id, double x, double y) {
  return {Kind::touch, false, id, 0, x, y};
}

Navigator make(NavigatorMode mode) {
  NavigatorSettings settings;
  settings.mode = mode;
  settings.start = {{0, 10, 0}, 0, 0};
  settings.centre_m = {0, 10, -100};
  settings.speed_m_s = 10;
  settings.eye_height_m = 2;
  settings.ground_m = [](const glm::dvec3& place) { return std::optional<double>(place.x * 0.5); };
  return Navigator(settings);
}

TEST(Navigator, FliesWhereItLooks) {
  Navigator n = make(NavigatorMode::fly);
  EXPECT_FALSE(n.moving());
  n.handle(key(KEY_W));
  EXPECT_TRUE(n.moving());
  EXPECT_TRUE(n.advance(0.1));
  EXPECT_NEAR(n.place().position_m.z, -1, 1e-9);  // yaw 0 looks to -z
  n.handle(key(KEY_W, false));
  n.advance(0.1);
  EXPECT_FALSE(n.moving());
  n.handle(key(KEY_A));
  n.handle(key(KEY_LEFTSHIFT));
  n.advance(0.1);
  EXPECT_NEAR(n.place().position_m.x, -4, 1e-9);
}

// Key 0 shows all of the world, from where a walker flies; Home goes back, and both set their speed.
TEST(Navigator, AllOfTheWorldByAKey) {
  NavigatorSettings settings;
  settings.mode = NavigatorMode::walk;
  settings.start = {{1, 12, 3}, 20, 0};
  settings.speed_m_s = 10;
  settings.overview = {{500, 300, 500}, 45, -30};
  settings.overview_speed_m_s = 100;
  settings.ground_m = [](const glm::dvec3&) { return std::optional<double>(10.3); };
  Navigator n(settings);
  EXPECT_TRUE(n.handle(key(KEY_0)));
  EXPECT_EQ(n.place().position_m, settings.overview.position_m);
  EXPECT_EQ(n.place().pitch_deg, -30);
  EXPECT_EQ(n.speed_m_s(), 100);
  EXPECT_EQ(n.mode(), NavigatorMode::fly);
  n.handle(key(KEY_3));
  EXPECT_TRUE(n.handle(key(KEY_HOME)));
  EXPECT_EQ(n.place().position_m, settings.start.position_m);
  EXPECT_EQ(n.speed_m_s(), 10);
}

TEST(Navigator, ATapBetweenFramesIsNotLost) {
  Navigator n = make(NavigatorMode::fly);
  n.handle(key(KEY_LEFT));
  n.handle(key(KEY_LEFT, false));
  EXPECT_TRUE(n.moving());
  EXPECT_TRUE(n.advance(0));
  EXPECT_GT(n.place().yaw_deg, 0);  // positive yaw turns left
  EXPECT_FALSE(n.moving());
}

TEST(Navigator, APauseIsNoJump) {
  Navigator n = make(NavigatorMode::fly);
  n.handle(key(KEY_W));
  n.advance(3600);
  EXPECT_GT(n.place().position_m.z, -5);
}

TEST(Navigator, OrbitKeepsItsDistance) {
  Navigator n = make(NavigatorMode::orbit);
  const glm::dvec3 target{0, 10, -100};
  n.handle(key(KEY_D));
  n.handle(key(KEY_UP));
  for (int i = 0; i < 50; ++i) {
    n.advance(0.05);
    EXPECT_NEAR(glm::length(n.place().position_m - target), 100, 1e-6);
  }
  EXPECT_GT(std::abs(n.place().yaw_deg), 30);
  EXPECT_TRUE(n.handle({Kind::wheel, false, 0, 0, 0, -1}));
  EXPECT_NEAR(glm::length(n.place().position_m - target), 80, 1e-6);
}

TEST(Navigator, WalksAboveTheGround) {
  Navigator n = make(NavigatorMode::walk);
  EXPECT_NEAR(n.place().position_m.y, 2, 1e-9);
  n.handle(key(KEY_D));
  n.advance(0.2);
  EXPECT_NEAR(n.place().position_m.x, 2, 1e-9);
  EXPECT_NEAR(n.place().position_m.y, 3, 1e-9);
}

TEST(Navigator, FingersTurnAndMove) {
  Navigator n = make(NavigatorMode::fly);
  EXPECT_FALSE(n.handle(finger(0, 0.5, 0.5)));
  EXPECT_TRUE(n.handle(finger(0, 0.6, 0.5)));
  EXPECT_NEAR(n.place().yaw_deg, 9, 1e-9);  // the ground follows the finger
  n.handle(finger(1, 0.8, 0.5));
  n.handle(finger(1, 0.9, 0.5));  // spreading goes forward
  const double yaw = 9 * 3.14159265358979 / 180;
  EXPECT_LT(n.place().position_m.z * std::cos(yaw) + n.place().position_m.x * std::sin(yaw), -1);
  n.handle({Kind::untouch, false, 1, 0, 0, 0});
  n.handle({Kind::untouch, false, 0, 0, 0, 0});
  EXPECT_FALSE(n.handle(finger(0, 0.1, 0.1)));
}

TEST(Navigator, HomeAndModes) {
  Navigator n = make(NavigatorMode::fly);
  n.handle(key(KEY_E));
  n.advance(0.1);
  EXPECT_GT(n.place().position_m.y, 10);
  EXPECT_TRUE(n.handle(key(KEY_HOME)));
  EXPECT_EQ(n.place().position_m.y, 10);
  n.handle(key(KEY_2));
  EXPECT_EQ(n.mode(), NavigatorMode::orbit);
  Navigator none = make(NavigatorMode::none);
  none.handle(key(KEY_W));
  EXPECT_FALSE(none.moving());
}

TEST(Input, PlacesTurnWithTheScreenAndMiceDoNot) {
  // The picture is turned counter-clockwise: its top edge is at the screen's left.
  const InputEvent left_middle = turned(finger(0, 0, 0.5), 1);
  EXPECT_EQ(left_middle.x, 0.5);
  EXPECT_EQ(left_middle.y, 0);
  const InputEvent half = turned(finger(0, 0.25, 0.5), 2);
  EXPECT_EQ(half.x, 0.75);
  EXPECT_EQ(half.y, 0.5);
  const InputEvent mouse = turned({Kind::motion, false, 0, 0, 3, 4}, 1);
  EXPECT_EQ(mouse.x, 3);
}

}  // namespace
}  // namespace karst::app
