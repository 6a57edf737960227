#include "report/front.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "output/number.hpp"
#include "report/gnuplot.hpp"

namespace odeval::report {
namespace {

// Colours that differ for colour-blind readers as well (Okabe and Ito, 2008); then other shapes of the same.
constexpr std::array colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7f00"};
constexpr std::array shapes{7, 5, 9, 13, 11, 6, 4};

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char letter : text) {
    if (letter == '\n') continue;
    out += letter;
    if (letter == '\'') out += letter;
  }
  return out + "'";
}

bool drawable(double value) { return std::isfinite(value) && value > 0; }

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
    const Series& series = panel.series[i];
    std::string block;
    for (std::size_t k = 0; k < std::min(series.x.size(), series.y.size()); ++k) {
      if (!drawable(series.x[k]) || !drawable(series.y[k])) continue;
      block += number_text(series.x[k]) + " " + number_text(series.y[k]) + "\n";
    }
    if (block.empty()) continue;
    script += fmt::format("$d{} << EOD\n{}EOD\n", i, block);
    plots += (plots.empty() ? "plot " : ", ") + fmt::format("$d{} using 1:2 with ", i);
    if (series.mark == Mark::points) {
      plots += fmt::format("points lc rgb '{}' pt {} ps 0.8", colours[i % colours.size()],
                           shapes[i / colours.size() % shapes.size()]);
    } else {
      plots += "linespoints lc rgb 'black' lw 1.5 pt 6 ps 1.6";
    }
    plots += " title " + quoted(series.label);
  }
  if (plots.empty()) return "";
  return run_gnuplot(script + plots + "\n");
}

}  // namespace odeval::report
