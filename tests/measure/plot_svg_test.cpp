// SPDX-License-Identifier: MIT
#include "bench/plots/plot_svg.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace karst::bench {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

PlotPanel panel() {
  PlotPanel result;
  result.x_label = "error <px>";
  result.y_label = "frame & ms";
  PlotSeries series;
  series.label = "ours";
  series.points = {{0.1, 20}, {1, 10}, {0, 5}, {10, std::nan("")}};
  result.series.push_back(series);
  return result;
}

TEST(PlotSvg, DrawsWhatALogarithmHasAndEscapesText) {
  const std::string svg = plot_svg("a < b", {panel()}, 1);
  EXPECT_EQ(count(svg, "<circle"), 3u);  // two points, one in the legend
  EXPECT_EQ(count(svg, "nan"), 0u);
  EXPECT_EQ(count(svg, "a &lt; b"), 1u);
  EXPECT_EQ(count(svg, "error &lt;px&gt;"), 1u);
  EXPECT_EQ(count(svg, "frame &amp; ms"), 1u);
  EXPECT_EQ(count(svg, "prefers-color-scheme:dark"), 1u);
  EXPECT_EQ(svg.substr(svg.size() - 7), "</svg>\n");
}

TEST(PlotSvg, PanelsOfAColumnShareTheirAxis) {
  PlotPanel other = panel();
  other.series[0].points = {{1000, 3}};
  const std::string svg = plot_svg("", {panel(), other}, 1);
  EXPECT_EQ(count(svg, ">1k</text>"), 2u);
  EXPECT_EQ(count(svg, ">ours</text>"), 1u);  // one legend
}

TEST(PlotSvg, NothingToDraw) {
  EXPECT_EQ(count(plot_svg("", {PlotPanel{}}, 1), "nan"), 0u);
  EXPECT_EQ(count(plot_svg("", {}, 3), "<circle"), 0u);
}

}  // namespace
}  // namespace karst::bench
