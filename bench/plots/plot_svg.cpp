// SPDX-License-Identifier: MIT
#include "bench/plots/plot_svg.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace karst::bench {
namespace {

// Pixels.
constexpr double kPanelWidth = 300, kPanelHeight = 210;
constexpr double kLeft = 64, kTop = 46, kGapX = 30, kGapY = 46, kBottom = 20;
constexpr double kLegendRow = 18, kLegendColumn = 236;

// Okabe and Ito, "Color Universal Design", 2008: told apart by the colour-blind; of middling lightness, so
// that they stand out on white and on near-black.
constexpr const char* kColours[kPlotColours] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                "#e69f00", "#56b4e9", "#8c6bb1", "#808080"};

struct Axis {
  double low = 0, high = 0;  // powers of ten
  bool used = false;

  void add(double value) {
    const double power = std::log10(value);
    low = used ? std::min(low, power) : power;
    high = used ? std::max(high, power) : power;
    used = true;
  }
  // A little air around the points, and at least a factor of three.
  void settle() {
    const double pad = std::max(0.05 * (high - low), 0.5 * (0.5 - (high - low)));
    low -= std::max(pad, 0.04);
    high += std::max(pad, 0.04);
  }
  double part(double value) const { return (std::log10(value) - low) / (high - low); }
};

__attribute__((format(printf, 2, 3))) void append(std::string& text, const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  text += buffer;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '&') {
      out += "&amp;";
    } else {
      out += c;
    }
  }
  return out;
}

bool drawable(PlotPoint p) {
  return p.x > 0 && p.y > 0 && std::isfinite(p.x) && std::isfinite(p.y);
}

void marker(std::string& svg, int kind, double x, double y, const char* colour) {
  switch (kind % kPlotMarkers) {
    case 0:
      append(svg, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3\" fill=\"%s\"/>\n", x, y, colour);
      break;
    case 1:
      append(svg, "<rect x=\"%.1f\" y=\"%.1f\" width=\"6\" height=\"6\" fill=\"%s\"/>\n", x - 3, y - 3,
             colour);
      break;
    case 2:
      append(svg, "<path d=\"M%.1f %.1fl4 7h-8z\" fill=\"%s\"/>\n", x, y - 4, colour);
      break;
    default:
      append(svg, "<path d=\"M%.1f %.1fl6 6m0 -6l-6 6\" stroke=\"%s\" stroke-width=\"2\"/>\n", x - 3, y - 3,
             colour);
  }
}

// A tick's value with as many digits as it needs: 0.02, 5, 20000 as 20k.
std::string tick_text(double value) {
  char text[32];
  const char* unit = "";
  if (value >= 0.999e6) {
    value /= 1e6;
    unit = "M";
  } else if (value >= 0.999e3) {
    value /= 1e3;
    unit = "k";
  }
  std::snprintf(text, sizeof text, "%g%s", value, unit);
  return text;
}

// Ticks at 1, 2 and 5 of each decade; only at 1 where there are more than three decades.
std::vector<double> ticks_of(const Axis& axis) {
  std::vector<double> ticks;
  const bool few = axis.high - axis.low > 3;
  for (double power = std::floor(axis.low); power <= axis.high; ++power) {
    for (const double digit : {1.0, 2.0, 5.0}) {
      if (few && digit > 1) continue;
      const double value = digit * std::pow(10.0, power);
      if (axis.part(value) >= 0 && axis.part(value) <= 1) ticks.push_back(value);
    }
  }
  return ticks;
}

struct Frame {
  double left, top;
  const Axis& x;
  const Axis& y;
  double px(double value) const { return left + kPanelWidth * x.part(value); }
  double py(double value) const { return top + kPanelHeight * (1 - y.part(value)); }
};

void draw_axes(std::string& svg, const Frame& frame, const PlotPanel& panel) {
  for (const double value : ticks_of(frame.x)) {
    append(svg, "<path class=\"grid\" d=\"M%.1f %.1fv%.1f\"/>", frame.px(value), frame.top, kPanelHeight);
    append(svg, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", frame.px(value),
           frame.top + kPanelHeight + 13, tick_text(value).c_str());
  }
  for (const double value : ticks_of(frame.y)) {
    append(svg, "<path class=\"grid\" d=\"M%.1f %.1fh%.1f\"/>", frame.left, frame.py(value), kPanelWidth);
    append(svg, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n", frame.left - 4,
           frame.py(value) + 4, tick_text(value).c_str());
  }
  append(svg, "<rect class=\"frame\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n", frame.left,
         frame.top, kPanelWidth, kPanelHeight);
  append(svg, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"middle\">%s</text>\n", frame.left + kPanelWidth / 2,
         frame.top + kPanelHeight + 28, escaped(panel.x_label).c_str());
  append(svg, "<text x=\"%.1f\" y=\"%.1f\" class=\"title\">%s</text>\n", frame.left, frame.top - 6,
         escaped(panel.y_label).c_str());
}

void draw_series(std::string& svg, const Frame& frame, const PlotSeries& series) {
  const char* colour = kColours[series.colour % kPlotColours];
  std::string path;
  for (const PlotPoint& p : series.points) {
    if (drawable(p)) append(path, "%c%.1f %.1f", path.empty() ? 'M' : 'L', frame.px(p.x), frame.py(p.y));
  }
  if (series.line && !path.empty()) {
    svg += "<path fill=\"none\" stroke-width=\"1.5\" stroke=\"" + std::string(colour) + "\"" +
           (series.dashed ? " stroke-dasharray=\"5 3\"" : "") + " d=\"" + path + "\"/>\n";
  }
  for (const PlotPoint& p : series.points) {
    if (drawable(p)) marker(svg, series.marker, frame.px(p.x), frame.py(p.y), colour);
  }
}

double draw_legend(std::string& svg, const std::vector<PlotPanel>& panels, double top, double width) {
  std::vector<std::string> shown;
  const int per_row = std::max(1, static_cast<int>((width - kLeft) / kLegendColumn));
  for (const PlotPanel& panel : panels) {
    for (const PlotSeries& series : panel.series) {
      if (std::find(shown.begin(), shown.end(), series.label) != shown.end()) continue;
      const int n = static_cast<int>(shown.size());
      shown.push_back(series.label);
      const double x = kLeft + kLegendColumn * (n % per_row), y = top + kLegendRow * (n / per_row);
      const char* colour = kColours[series.colour % kPlotColours];
      if (series.line) {
        append(svg, "<path stroke-width=\"1.5\" stroke=\"%s\"%s d=\"M%.1f %.1fh24\"/>", colour,
               series.dashed ? " stroke-dasharray=\"5 3\"" : "", x, y);
      }
      marker(svg, series.marker, x + 12, y, colour);
      append(svg, "<text x=\"%.1f\" y=\"%.1f\">%s</text>\n", x + 30, y + 4, escaped(series.label).c_str());
    }
  }
  return kLegendRow * static_cast<double>((static_cast<int>(shown.size()) + per_row - 1) / per_row);
}

}  // namespace

std::string plot_svg(const std::string& title, const std::vector<PlotPanel>& panels, int columns) {
  const auto across = static_cast<std::size_t>(columns);
  const std::size_t rows = (panels.size() + across - 1) / across;
  std::vector<Axis> x(across), y(rows);
  for (std::size_t n = 0; n < panels.size(); ++n) {
    for (const PlotSeries& series : panels[n].series) {
      for (const PlotPoint& p : series.points) {
        if (!drawable(p)) continue;
        x[n % across].add(p.x);
        y[n / across].add(p.y);
      }
    }
  }
  for (Axis& axis : x) axis.settle();
  for (Axis& axis : y) axis.settle();

  const double pitch_x = kPanelWidth + kLeft + kGapX - 40, pitch_y = kPanelHeight + kGapY + 14;
  const double width = kLeft + pitch_x * static_cast<double>(across);
  std::string body;
  for (std::size_t n = 0; n < panels.size(); ++n) {
    const Frame frame{kLeft + pitch_x * static_cast<double>(n % across),
                      kTop + pitch_y * static_cast<double>(n / across), x[n % across], y[n / across]};
    draw_axes(body, frame, panels[n]);
    for (const PlotSeries& series : panels[n].series) draw_series(body, frame, series);
  }
  const double legend_top = kTop + pitch_y * static_cast<double>(rows) + 4;
  const double height = legend_top + draw_legend(body, panels, legend_top, width) + kBottom;

  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" ";
  append(svg, "width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\">\n", width, height, width, height);
  svg +=
      "<style>text{font:11px sans-serif;fill:#222}.title{font-weight:bold}.paper{fill:#fff}"
      ".grid{stroke:#ddd}.frame{fill:none;stroke:#666}\n"
      "@media(prefers-color-scheme:dark){text{fill:#ddd}.paper{fill:#161b22}.grid{stroke:#30363d}"
      ".frame{stroke:#8b949e}}</style>\n";
  append(svg, "<rect class=\"paper\" width=\"%.0f\" height=\"%.0f\"/>\n", width, height);
  append(svg, "<text x=\"%.0f\" y=\"18\" class=\"title\">%s</text>\n", kLeft, escaped(title).c_str());
  return svg + body + "</svg>\n";
}

}  // namespace karst::bench
