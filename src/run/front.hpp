#pragma once
// What a sweep answers: the least error that a cost buys.
#include <algorithm>
#include <limits>
#include <tuple>
#include <vector>

namespace odeval::sweep {

struct Point {
  long run = 0;
  double cost = 0;
  double error = 0;
  bool told = true;  // false: the reference is no better known than that
};

/// The Pareto front: those points that no other is as cheap and as good as, cheapest first. Of equal ones the first
/// run. Points without a finite error are none; one whose error cannot be told has to be better by half than the one
/// before it on the front.
inline std::vector<Point> pareto_front(std::vector<Point> points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return std::tie(a.cost, a.error, a.run) < std::tie(b.cost, b.error, b.run);
  });
  std::vector<Point> front;
  double least = std::numeric_limits<double>::infinity();  // of all that are cheaper
  for (const Point& point : points) {
    if (!(point.error < least)) continue;
    least = point.error;
    if (point.told || front.empty() || point.error < front.back().error / 2) front.push_back(point);
  }
  return front;
}

}  // namespace odeval::sweep
