#include "report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "output/number.hpp"
#include "report/gnuplot.hpp"
#include "report/gnuplot_script.hpp"

namespace odeval::report {
namespace {

constexpr std::size_t most_points = 4000;  // of a line: more than two a pixel

/// The lowest and the highest point of each few that have a place, in their order.
Series thinned(const Series& series, const Panel& panel) {
  const std::size_t points = std::min(series.x.size(), series.y.size());
  if (points <= most_points) return series;
  const std::size_t few = (2 * points + most_points - 1) / most_points;
  Series thin{series.label, {}, {}, series.mark, series.colour, series.dashed};
  const auto add = [&](std::size_t at) {
    thin.x.push_back(series.x[at]);
    thin.y.push_back(series.y[at]);
  };
  for (std::size_t begin = 0; begin < points; begin += few) {
    std::vector<std::size_t> places;
    for (std::size_t at = begin; at < std::min(begin + few, points); ++at) {
      if (drawable(series.x[at], panel.log_x) && drawable(series.y[at], panel.log_y)) places.push_back(at);
    }
    if (places.empty()) {
      add(begin);  // a gap
      continue;
    }
    const auto by_height = [&](std::size_t a, std::size_t b) { return series.y[a] < series.y[b]; };
    const auto [low, high] = std::ranges::minmax_element(places, by_height);
    add(std::min(*low, *high));
    if (*low != *high) add(std::max(*low, *high));
  }
  return thin;
}

/// One x axis for all panels, whether or not a logarithmic y axis has a place for the first rows; and one width,
/// whatever the legends: so that what happens at one time stands at one place.
std::string common_x(const Chart& chart) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::size_t longest = 0;
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      longest = std::max(longest, series.label.size());
      for (const double x : series.x) {
        if (!drawable(x, panel.log_x)) continue;
        low = std::min(low, x);
        high = std::max(high, x);
      }
    }
  }
  constexpr std::size_t sample = 8;  // of a line, in letters, with the blanks about it
  const std::string range =
      low < high ? fmt::format("set xrange [{}:{}]\n", number_text(low), number_text(high)) : "set autoscale xfix\n";
  return fmt::format("set rmargin {}\n", longest + sample) + range;
}

std::string terminal(const Chart& chart, ChartFormat format) {
  const char* const kind = format == ChartFormat::svg ? "svg background 'white'" : "pngcairo";
  return fmt::format("set terminal {} size {},{} font 'DejaVu Sans,12'\n", kind, chart.width, chart.height);
}

}  // namespace

std::string drawn(const Chart& chart, ChartFormat format) {
  std::string script = terminal(chart, format) +
                       "set encoding utf8\nset tics nomirror\nset border 3\nset format '%h'\nset lmargin 12\n"
                       "set grid lc rgb '#dddddd' lw 1 dt solid\nset key outside right top noenhanced\n" +
                       common_x(chart);
  std::string plots;
  std::size_t number = 0;
  for (std::size_t k = 0; k < chart.panels.size(); ++k) {
    const Panel& panel = chart.panels[k];
    const bool last = k + 1 == chart.panels.size();
    plots += fmt::format("set xlabel {} noenhanced\nset ylabel {} noenhanced\n", quoted(last ? panel.x_label : ""),
                         quoted(panel.y_label));
    plots += panel.log_y ? "set logscale y\nset format y '10^{%L}'\n" : "unset logscale y\nset format y '%h'\n";
    plots += panel.y_range ? fmt::format("set yrange [{}:{}]\n", number_text(panel.y_range->first),
                                         number_text(panel.y_range->second))
                           : "set autoscale y\n";
    plots += fmt::format("set title {} noenhanced font ',10'\n", quoted(panel.title));
    std::string lines;
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      const Series series = thinned(panel.series[i], panel);
      script += data_block(series, panel, number);
      const std::size_t colour = series.colour < 0 ? i : static_cast<std::size_t>(series.colour);
      lines += fmt::format("{}$d{} using 1:2 with lines lc rgb '{}' lw 1.5 dt {} title {}",
                           lines.empty() ? "plot " : ", ", number++, own_colours[colour % own_colours.size()],
                           1 + colour / own_colours.size() % 5, quoted(series.label));
    }
    plots += lines + "\n";
  }
  script += fmt::format("set multiplot layout {},1 title {} noenhanced\n", chart.panels.size(), quoted(chart.title));
  return run_gnuplot(script + plots + "unset multiplot\n");
}

}  // namespace odeval::report
