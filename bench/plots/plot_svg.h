// SPDX-License-Identifier: MIT
// Panels of points and lines on two logarithmic axes, as one SVG picture that can be read on light and on
// dark pages.
#pragma once

#include <string>
#include <vector>

namespace karst::bench {

struct PlotPoint {
  double x = 0, y = 0;  // points that are not above 0 are left out
};

struct PlotSeries {
  std::string label;  // legends show each label once
  int colour = 0;     // of kPlotColours
  bool dashed = false;
  bool line = true;  // false: markers alone
  int marker = 0;    // of kPlotMarkers
  std::vector<PlotPoint> points;
};
inline constexpr int kPlotColours = 8;
inline constexpr int kPlotMarkers = 4;  // circle, square, triangle, cross

struct PlotPanel {
  std::string x_label, y_label;
  std::vector<PlotSeries> series;
};

// Panels fill rows from the left; those of a column share the x axis's range, those of a row the y axis's.
// A panel without points stays empty. columns: at least 1.
std::string plot_svg(const std::string& title, const std::vector<PlotPanel>& panels, int columns);

}  // namespace karst::bench
