#include "report/chart.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "output/number.hpp"
#include "report/gnuplot.hpp"
#include "report/gnuplot_script.hpp"

namespace odeval::report {
namespace {

constexpr std::size_t most_points = 4000;  // of a line: more than two a pixel

/// The lowest and the highest point of each few, in their order.
Series thinned(const Series& series) {
  const std::size_t points = std::min(series.x.size(), series.y.size());
  if (points <= most_points) return series;
  const std::size_t few = (2 * points + most_points - 1) / most_points;
  Series thin{series.label, {}, {}, series.mark, series.colour, series.dashed};
  for (std::size_t begin = 0; begin < points; begin += few) {
    const auto first = series.y.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto [low, high] =
        std::minmax_element(first, first + static_cast<std::ptrdiff_t>(std::min(few, points - begin)));
    for (const auto at : {std::min(low, high), std::max(low, high)}) {
      thin.x.push_back(series.x[static_cast<std::size_t>(at - series.y.begin())]);
      thin.y.push_back(*at);
      if (low == high) break;
    }
  }
  return thin;
}

std::string terminal(const Chart& chart, ChartFormat format) {
  const char* const kind = format == ChartFormat::svg ? "svg background 'white'" : "pngcairo";
  return fmt::format("set terminal {} size {},{} font 'DejaVu Sans,12'\n", kind, chart.width, chart.height);
}

}  // namespace

std::string drawn(const Chart& chart, ChartFormat format) {
  std::string script = terminal(chart, format) +
                       "set encoding utf8\nset tics nomirror\nset border 3\nset format '%h'\nset lmargin 12\n"
                       "set grid lc rgb '#dddddd' lw 1 dt solid\nset key outside right top noenhanced\n"
                       "set autoscale xfix\n";
  std::string plots;
  std::size_t number = 0;
  for (std::size_t k = 0; k < chart.panels.size(); ++k) {
    const Panel& panel = chart.panels[k];
    const bool last = k + 1 == chart.panels.size();
    plots += fmt::format("set xlabel {} noenhanced\nset ylabel {} noenhanced\n", quoted(last ? panel.x_label : ""),
                         quoted(panel.y_label));
    plots += panel.log_y ? "set logscale y\nset format y '10^{%L}'\n" : "unset logscale y\nset format y '%h'\n";
    std::string lines;
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      const Series series = thinned(panel.series[i]);
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
