#include "report/gnuplot_script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "output/number.hpp"

namespace odeval::report {

std::string quoted(const std::string& text) {
  std::string out = "'";
  for (const char letter : text) {
    if (letter == '\n') continue;
    out += letter;
    if (letter == '\'') out += letter;
  }
  return out + "'";
}

bool drawable(double value, bool log) { return std::isfinite(value) && (!log || value > 0); }

std::string data_block(const Series& series, const Panel& panel, std::size_t number) {
  std::string block = fmt::format("$d{} << EOD\n", number);
  for (std::size_t i = 0; i < std::min(series.x.size(), series.y.size()); ++i) {
    const bool there = drawable(series.x[i], panel.log_x) && drawable(series.y[i], panel.log_y);
    block += there ? number_text(series.x[i]) + " " + number_text(series.y[i]) + "\n" : "NaN NaN\n";
  }
  return block + "EOD\n";
}

}  // namespace odeval::report
