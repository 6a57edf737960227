#include "report/log_axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace odeval::report {
namespace {

constexpr std::size_t one_in = 100;   // of a series' values may lie below
constexpr double far_below = 100;     // the rest, by that factor
constexpr std::size_t few = 10;       // values, of which none may: two or three make a line
constexpr double of_rounding = 1e-9;  // a value that is a power of ten is not moved to the next

double decade_below(double value) { return std::pow(10, std::floor(std::log10(value) + of_rounding)); }
double decade_above(double value) { return std::pow(10, std::ceil(std::log10(value) - of_rounding)); }

/// The lowest value of a series that the axis has to have.
double least_of(Column values, Mark mark) {
  if (mark != Mark::line || values.size() < few) return std::ranges::min(values);
  const std::size_t left_out = std::max<std::size_t>(1, values.size() / one_in);
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(left_out));
  const double rest = values[left_out];
  double least = rest;
  for (const double value : values) {
    if (value * far_below > rest) least = std::min(least, value);
  }
  return least;
}

}  // namespace

LogAxis log_axis_of(const Panel& panel) {
  LogAxis axis;
  double least = std::numeric_limits<double>::infinity();
  double greatest = 0;
  std::vector<Column> all;
  for (const Series& series : panel.series) {
    Column& above = all.emplace_back();
    for (const double value : series.y) {
      if (!std::isfinite(value)) continue;
      ++axis.values;
      if (value > 0) above.push_back(value);
    }
    if (above.empty()) continue;
    greatest = std::max(greatest, std::ranges::max(above));
    least = std::min(least, least_of(above, series.mark));
  }
  for (const Column& above : all) axis.zeros += above.size();
  axis.zeros = axis.values - axis.zeros;
  if (greatest == 0) return axis;
  axis.least = decade_below(least);
  axis.greatest = std::max(decade_above(greatest), 10 * axis.least);
  for (const Column& above : all) {
    axis.below +=
        static_cast<std::size_t>(std::ranges::count_if(above, [&](double value) { return value < axis.least; }));
  }
  return axis;
}

std::string left_out_text(const LogAxis& axis) {
  if (axis.zeros + axis.below == 0) return "";
  std::string text = "not drawn: ";
  if (axis.zeros > 0) text += fmt::format("{} value{} of 0", axis.zeros, axis.zeros == 1 ? "" : "s");
  if (axis.zeros > 0 && axis.below > 0) text += ", ";
  if (axis.below > 0) text += fmt::format("{} below {:.0e}", axis.below, axis.least);
  return text + fmt::format(", of {}", axis.values);
}

}  // namespace odeval::report
