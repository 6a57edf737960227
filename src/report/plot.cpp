#include "report/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "output/number.hpp"
#include "report/gnuplot.hpp"
#include "report/gnuplot_script.hpp"
#include "report/log_axis.hpp"
#include "report/svg.hpp"
#include "report/text.hpp"

namespace odeval::report {
namespace {

constexpr int clear_colours = 8;  // of the methods': those that everybody tells apart
constexpr int dotted = 3;         // of the dashes

constexpr double most_ticked_decades = 1e8;  // more leave no room for ticks within each

struct Dash {
  const char* gnuplot;  // in units of the line's width
  const char* svg;
};
// Solid first; then for series that ask for dashes, and for colours beyond the clear ones.
constexpr std::array<Dash, 5> dashes{
    {{"solid", ""}, {"(8,5)", "6,3"}, {"(14,5,3,5)", "10,3,2,3"}, {"(3,4)", "2,3"}, {"(20,6)", "14,4"}}};

struct Marker {
  int gnuplot;      // point type
  const char* svg;  // about the origin, 8 units across
};
constexpr std::array<Marker, 5> markers{{{7, "M-4,0 a4,4 0 1,0 8,0 a4,4 0 1,0 -8,0 z"},
                                         {5, "M-3.5,-3.5 h7 v7 h-7 z"},
                                         {9, "M0,-4.5 L-4,3 L4,3 z"},
                                         {13, "M0,-4.5 L4.5,0 L0,4.5 L-4.5,0 z"},
                                         {11, "M0,4.5 L-4,-3 L4,-3 z"}}};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

struct Ranges {
  Range x;
  Range y;
};

/// Of all points that can be drawn.
Ranges ranges_of(const Panel& panel) {
  Ranges ranges;
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
      if (!drawable(series.x[i], panel.log_x) || !drawable(series.y[i], panel.log_y)) continue;
      ranges.x.add(series.x[i]);
      ranges.y.add(series.y[i]);
    }
  }
  return ranges;
}

/// From 1, 2 or 5 times a power of ten to another, just around the values; whole decades where fewer than two powers of
/// ten would be labelled.
Range around(const Range& range) {
  constexpr double of_rounding = 1e-9;
  const double low = std::floor(std::log10(range.low) + of_rounding);
  const double high = std::ceil(std::log10(range.high) - of_rounding);
  Range near{std::pow(10, low), std::pow(10, high)};
  for (const double digit : {2.0, 5.0}) {
    if (digit * std::pow(10, low) <= range.low * (1 + of_rounding)) near.low = digit * std::pow(10, low);
    if (std::pow(10, high) / digit >= range.high * (1 - of_rounding)) near.high = std::pow(10, high) / digit;
  }
  const double first = std::ceil(std::log10(near.low) - of_rounding);
  const double last = std::floor(std::log10(near.high) + of_rounding);
  if (last > first) return near;
  return {std::pow(10, low), std::pow(10, high > low ? high : low + 1)};
}

/// What has no extent is given some.
Range widened(const Range& range) {
  if (range.high > range.low) return range;
  const double by = range.low == 0 ? 1 : std::fabs(range.low) / 2;
  return {range.low - by, range.high + by};
}

/// `log` is what an axis has that is logarithmic.
std::string axis(char name, const Range& range, const std::optional<Range>& log, bool tight) {
  const Range shown = log ? *log : widened(range);
  std::string script;
  if (log) script += fmt::format("set logscale {0}\nset format {0} '10^{{%L}}'\n", name);
  if (log && shown.high > most_ticked_decades * shown.low) script += fmt::format("unset m{}tics\n", name);
  if (log || range.high <= range.low) {
    script += fmt::format("set {}range [{}:{}]\n", name, number_text(shown.low), number_text(shown.high));
  } else if (tight) {
    script += fmt::format("set autoscale {}fix\n", name);
  }
  return script;
}

}  // namespace

bool has_points(const Series& series, const Panel& panel) {
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    if (drawable(series.x[i], panel.log_x) && drawable(series.y[i], panel.log_y)) return true;
  }
  return false;
}

namespace {

std::string plotted(const Series& series, const Look& look, std::size_t number) {
  const char* const style = look.has_line && look.has_points ? "linespoints" : look.has_line ? "lines" : "points";
  std::string text = fmt::format("$d{} using 1:2 with {} lc rgb '{}'", number, style, svg_colour_code(look.colour));
  if (look.has_line) text += fmt::format(" lw 1.6 dt {}", dashes[static_cast<std::size_t>(look.dash)].gnuplot);
  if (look.has_points) text += fmt::format(" pt {} ps 0.6", markers[static_cast<std::size_t>(look.marker)].gnuplot);
  return text + " title " + quoted(series.label) + " noenhanced";
}

/// From where on the panel is shaded, within what it shows.
std::optional<double> shaded_from(const Panel& panel) {
  const Range x = ranges_of(panel).x;
  if (!panel.shade || x.empty() || !drawable(panel.shade->from, panel.log_x) || panel.shade->from >= x.high) return {};
  return std::max(panel.shade->from, x.low);
}

std::string script_of(const Panel& panel, const std::vector<Look>& looks) {
  const Ranges ranges = ranges_of(panel);
  const bool lines_only = std::ranges::all_of(looks, [](const Look& look) { return !look.has_points; });
  std::string script = fmt::format("set terminal svg size {},{} dynamic enhanced font ',{}'\n", svg_width,
                                   panel.equal_axes ? svg_width * 9 / 10 : svg_width * 2 / 3, svg_font_size);
  script += "set encoding utf8\nset key off\nset tics nomirror\nset format '%h'\n";
  script += fmt::format("set border 3 lc rgb '{}'\n", svg_colour_code(svg_ink));
  script += fmt::format("set grid lc rgb '{}' lw 1 dt solid\n", svg_colour_code(svg_grid));
  script +=
      "set xlabel " + quoted(panel.x_label) + " noenhanced\nset ylabel " + quoted(panel.y_label) + " noenhanced\n";
  std::optional<Range> log_x;
  std::optional<Range> log_y;
  if (panel.log_x) log_x = around(ranges.x);
  if (panel.log_y) {
    const LogAxis whole = log_axis_of(panel);
    log_y = {whole.least, whole.greatest};
  }
  script += "set xtics autofreq\n" + axis('x', ranges.x, log_x, lines_only && !panel.equal_axes);
  script += axis('y', ranges.y, log_y, false);
  if (panel.equal_axes) script += "set size ratio -1\n";
  if (panel.y_range) {
    script +=
        fmt::format("set yrange [{}:{}]\n", number_text(panel.y_range->first), number_text(panel.y_range->second));
  }
  if (const std::optional<double> from = shaded_from(panel)) {
    script += fmt::format(
        "set object 1 rectangle from first {}, graph 0 to graph 1, graph 1 behind fillcolor rgb '{}' "
        "fillstyle solid 1 noborder\n",
        number_text(*from), svg_colour_code(svg_shade));
  }
  std::string plots;
  for (const bool behind : {true, false}) {
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      if ((looks[i].colour == rest_colour) != behind || !has_points(panel.series[i], panel)) continue;
      script += data_block(panel.series[i], panel, i);
      plots += (plots.empty() ? "plot " : ", ") + plotted(panel.series[i], looks[i], i);
    }
  }
  return script + plots + "\n";
}

std::string described(const Panel& panel) {
  std::string text = panel.y_label + " against " + panel.x_label;
  std::string labels;
  for (const Series& series : panel.series) {
    if (!series.label.empty()) labels += (labels.empty() ? ": " : ", ") + series.label;
  }
  return text + labels;
}

Look look_of(const Series& series, int index) {
  const bool has_line = series.mark != Mark::points;
  const bool has_points = series.mark != Mark::line;
  const int marker = index % static_cast<int>(markers.size());
  if (index == rest_colour) return {rest_colour, series.dashed ? 1 : 0, marker, has_line, !has_line};
  if (index == guide_colour) return {guide_colour, dotted, marker, has_line, has_points};
  if (index < method_colours) {
    const int unclear = index >= clear_colours ? 1 : 0;
    return {index, series.dashed ? 1 + 2 * unclear : 2 * unclear, marker, has_line, has_points};
  }
  const int variant = index - first_variant;
  const int round = variant / variant_colours;
  return {first_variant + variant % variant_colours, series.dashed ? 1 + 2 * (round % 2) : 2 * (round % 3),
          (variant + round) % static_cast<int>(markers.size()), has_line, has_points};
}

/// The first variant's index that nothing has taken.
int free_index(const std::vector<int>& taken) {
  int index = first_variant;
  while (std::ranges::find(taken, index) != taken.end()) ++index;
  return index;
}

}  // namespace

std::vector<std::vector<Look>> looks_of(const Figure& figure) {
  std::vector<int> taken;
  for (const Panel& panel : figure.panels) {
    for (const Series& series : panel.series) {
      if (series.colour >= 0) taken.push_back(series.colour);
    }
  }
  std::vector<std::pair<std::string, int>> given;  // the same label has the same colour in all panels
  std::vector<std::vector<Look>> looks;
  for (const Panel& panel : figure.panels) {
    std::vector<Look>& row = looks.emplace_back();
    for (const Series& series : panel.series) {
      int index = series.colour;
      if (index < 0) {
        const auto known = std::ranges::find(given, series.label, &std::pair<std::string, int>::first);
        if (known != given.end() && !series.label.empty()) {
          index = known->second;
        } else {
          index = free_index(taken);
          taken.push_back(index);
          given.emplace_back(series.label, index);
        }
      }
      row.push_back(look_of(series, index));
    }
  }
  return looks;
}

bool has_points(const Panel& panel) { return !ranges_of(panel).x.empty(); }

std::string plot_svg(const Panel& panel, const std::vector<Look>& looks, const std::string& id) {
  return page_svg(run_gnuplot(script_of(panel, looks)), id, described(panel));
}

std::string swatch_svg(const Look& look) {
  std::string shapes;
  if (look.has_line) {
    shapes += fmt::format("<path d=\"M1,6 H33\" style=\"stroke:var(--c{})\"", look.colour);
    if (look.dash > 0)
      shapes += fmt::format(" stroke-dasharray=\"{}\"", dashes[static_cast<std::size_t>(look.dash)].svg);
    shapes += "/>";
  }
  if (look.has_points) {
    shapes += fmt::format("<path transform=\"translate(17,6)\" d=\"{}\" style=\"fill:var(--c{});stroke:none\"/>",
                          markers[static_cast<std::size_t>(look.marker)].svg, look.colour);
  }
  return "<svg class=\"swatch\" viewBox=\"0 0 34 12\" aria-hidden=\"true\" xmlns=\"http://www.w3.org/2000/svg\">" +
         shapes + "</svg>";
}

std::string shade_text(const Panel& panel) {
  if (!shaded_from(panel)) return "";
  const std::size_t comma = panel.x_label.find(", ");
  const std::string name = panel.x_label.substr(0, comma);
  const std::string unit = comma == std::string::npos ? "" : " " + panel.x_label.substr(comma + 2);
  return fmt::format("Shaded from {} = {}{} on: {}", name, shown(panel.shade->from), unit, panel.shade->why);
}

std::string not_drawn_text(const Panel& panel) {
  if (!panel.log_y || panel.y_range) return "";
  std::string text = left_out_text(log_axis_of(panel));
  if (!text.empty()) text.front() = 'N';
  return text;
}

}  // namespace odeval::report
