#pragma once
// As many points of a long curve as a picture can show.
#include <cstddef>
#include <vector>

namespace odeval::audit {

/// Of points that come one by one, so many that each stands for as many as the others do: `Point::take` makes one of
/// two that follow each other.
template <class Point>
class Thinned {
 public:
  void add(const Point& point) {
    if (points_.empty() || in_last_ == each_) {
      if (points_.size() == most) halve();
      points_.push_back(point);
      in_last_ = 1;
    } else {
      points_.back().take(point);
      ++in_last_;
    }
  }

  const std::vector<Point>& points() const { return points_; }

 private:
  static constexpr std::size_t most = 1000;

  void halve() {
    for (std::size_t i = 0; i < most / 2; ++i) {
      points_[i] = points_[2 * i];
      points_[i].take(points_[2 * i + 1]);
    }
    points_.resize(most / 2);
    each_ *= 2;
  }

  std::vector<Point> points_;
  std::size_t each_ = 1;  // points stand for
  std::size_t in_last_ = 0;
};

}  // namespace odeval::audit
