#include "measure/order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace odeval {
namespace {

constexpr std::array quantiles{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                               2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086,
                               2.080,  2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042};

bool counts(const ErrorPoint& point, double lost) {
  return point.error > 0 && point.error <= lost && point.error >= clear_of_uncertainty * point.uncertainty;
}

}  // namespace

double student_t_95(int degrees_of_freedom) {
  const int last = static_cast<int>(quantiles.size());
  return quantiles[static_cast<std::size_t>(std::clamp(degrees_of_freedom, 1, last) - 1)];
}

double rounding_uncertainty(double epsilon, long steps) { return epsilon * std::sqrt(static_cast<double>(steps)); }

std::optional<ObservedOrder> observed_order(std::span<const ErrorPoint> points, double lost) {
  std::vector<ErrorPoint> used;
  std::ranges::copy_if(points, std::back_inserter(used), [lost](const ErrorPoint& p) { return counts(p, lost); });
  const auto n = static_cast<double>(used.size());
  if (used.size() < 3) return std::nullopt;

  double x_mean = 0;
  double y_mean = 0;
  for (const ErrorPoint& p : used) {
    x_mean += std::log(p.setting) / n;
    y_mean += std::log(p.error) / n;
  }
  double spread = 0;
  for (const ErrorPoint& p : used) spread += std::pow(std::log(p.setting) - x_mean, 2);
  if (spread == 0) return std::nullopt;

  double slope = 0;
  double uncertainty = 0;
  for (const ErrorPoint& p : used) {
    const double weight = (std::log(p.setting) - x_mean) / spread;
    slope += weight * (std::log(p.error) - y_mean);
    uncertainty += std::fabs(weight) * -std::log1p(-p.uncertainty / p.error);
  }
  double residue = 0;
  for (const ErrorPoint& p : used) {
    residue += std::pow(std::log(p.error) - y_mean - slope * (std::log(p.setting) - x_mean), 2);
  }
  const double standard_error = std::sqrt(residue / (n - 2) / spread);
  const auto [from, to] = std::ranges::minmax(used, {}, &ErrorPoint::setting);
  return ObservedOrder{slope, student_t_95(static_cast<int>(used.size()) - 2) * standard_error + uncertainty,
                       from.setting, to.setting, static_cast<int>(used.size())};
}

std::vector<ErrorPoint> settled_points(std::span<const ErrorPoint> points, double lost) {
  std::vector<ErrorPoint> used;
  std::ranges::copy_if(points, std::back_inserter(used), [lost](const ErrorPoint& p) { return counts(p, lost); });
  std::ranges::sort(used, std::ranges::greater(), &ErrorPoint::setting);
  std::vector<double> slopes;
  for (std::size_t i = 0; i + 1 < used.size(); ++i) {
    slopes.push_back(std::log(used[i].error / used[i + 1].error) / std::log(used[i].setting / used[i + 1].setting));
  }
  for (std::size_t first = 0; first + 2 < used.size(); ++first) {
    const bool settled = std::all_of(slopes.begin() + static_cast<std::ptrdiff_t>(first) + 1, slopes.end(),
                                     [&](double finer) { return std::fabs(finer - slopes[first]) <= settled_slopes; });
    if (settled) return {used.begin() + static_cast<std::ptrdiff_t>(first), used.end()};
  }
  return {};
}

}  // namespace odeval
