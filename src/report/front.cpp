#include "report/front.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "report/gnuplot.hpp"
#include "report/gnuplot_script.hpp"

namespace odeval::report {
namespace {

constexpr std::array shapes{7, 5, 9, 13, 11, 6, 4};  // of points, once the colours are used up

/// Those of its points that have a place on logarithmic axes.
Series drawable_points(const Series& series) {
  Series points{series.label, {}, {}, series.mark, series.colour, series.dashed};
  for (std::size_t k = 0; k < std::min(series.x.size(), series.y.size()); ++k) {
    if (!drawable(series.x[k], true) || !drawable(series.y[k], true)) continue;
    points.x.push_back(series.x[k]);
    points.y.push_back(series.y[k]);
  }
  return points;
}

}  // namespace

std::string front_png(const Panel& panel, const std::string& title) {
  std::string script =
      "set terminal pngcairo size 1200,760 font 'DejaVu Sans,12'\nset encoding utf8\n"
      "set logscale xy\nset format xy '10^{%L}'\nset tics nomirror\nset border 3\n"
      "set grid lc rgb '#dddddd' lw 1 dt solid\nset key outside right top noenhanced\n";
  script += "set title " + quoted(title) + " noenhanced\n";
  script +=
      "set xlabel " + quoted(panel.x_label) + " noenhanced\nset ylabel " + quoted(panel.y_label) + " noenhanced\n";
  std::string plots;
  for (std::size_t i = 0; i < panel.series.size(); ++i) {
    const Series series = drawable_points(panel.series[i]);
    if (series.x.empty()) continue;
    script += data_block(series, panel, i);
    plots += (plots.empty() ? "plot " : ", ") + fmt::format("$d{} using 1:2 with ", i);
    if (series.mark == Mark::points) {
      plots += fmt::format("points lc rgb '{}' pt {} ps 0.8", own_colours[i % own_colours.size()],
                           shapes[i / own_colours.size() % shapes.size()]);
    } else {
      plots += fmt::format("linespoints lc rgb 'black' lw 1.5 dt {} pt 6 ps 1.6", series.dashed ? "'-'" : "solid");
    }
    plots += " title " + quoted(series.label);
  }
  if (plots.empty()) return "";
  return run_gnuplot(script + plots + "\n");
}

}  // namespace odeval::report
