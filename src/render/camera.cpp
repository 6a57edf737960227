#include "render/camera.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace odeval::render {
namespace {

constexpr double half_view_deg = 12.5;  // half the vertical angle of view: a long lens, little distortion
constexpr double fill = 0.94;           // of the picture, between the margins

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

/// Where an eye sees points between two lines through it, x = eye ± slope * (z - eye_z): as close as possible.
struct Bounds {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  double slope;

  void hold(double x, double z) {
    high = std::max(high, x - slope * z);
    low = std::min(low, x + slope * z);
  }
  double middle() const { return (low + high) / 2; }
  double eye_z() const { return (low - high) / (2 * slope); }
};

}  // namespace

Camera::Camera(const PlanarFrame& frame, const View& view, std::span<const Vec3> points, int width, int height)
    : width_(width), height_(height) {
  const double azimuth = radians(view.azimuth_deg);
  const double elevation = radians(view.elevation_deg);
  const Vec3 level = std::cos(azimuth) * frame.axis() + std::sin(azimuth) * frame.horizontal;
  forward_ = -1 * (std::cos(elevation) * level + std::sin(elevation) * frame.up);
  right_ = unit(cross(forward_, frame.up));
  up_ = cross(right_, forward_);
  focal_ = height / 2.0 / std::tan(radians(half_view_deg));

  Bounds across{.slope = fill * width / 2 / focal_};
  Bounds upright{.slope = fill * height / 2 / focal_};
  for (const Vec3& point : points) {
    const Vec3 from_hinge = point - frame.hinge_m;
    across.hold(dot(from_hinge, right_), dot(from_hinge, forward_));
    upright.hold(dot(from_hinge, up_), dot(from_hinge, forward_));
  }
  distance_m_ = view.distance_m.value_or(-std::min(across.eye_z(), upright.eye_z()));
  eye_ = frame.hinge_m + across.middle() * right_ + upright.middle() * up_ - distance_m_ * forward_;
}

Pixel Camera::project(const Vec3& point) const {
  const Vec3 seen = point - eye_;
  const double depth = dot(seen, forward_);
  return {width_ / 2.0 + focal_ * dot(seen, right_) / depth, height_ / 2.0 - focal_ * dot(seen, up_) / depth, depth};
}

double Camera::pixel_m(const Vec3& point) const { return std::fabs(dot(point - eye_, forward_)) / focal_; }

std::array<float, 16> Camera::clip_matrix(const Tile& tile) const {
  const double near = distance_m_ / 50;
  const double far = distance_m_ * 20;
  // Rows of the projection in the camera's own axes (right, up, forward); the last column is the constant.
  const double sx = 2 * focal_ / tile.width;
  const double sy = 2 * focal_ / tile.height;
  const double shift_x = static_cast<double>(width_ - 2 * tile.x) / tile.width - 1;
  const double shift_y = 1 - static_cast<double>(height_ - 2 * tile.y) / tile.height;
  const std::array<Vec3, 4> rows{sx * right_ + shift_x * forward_, sy * up_ + shift_y * forward_,
                                 ((far + near) / (far - near)) * forward_, forward_};
  const std::array<double, 4> constants{0, 0, -2 * far * near / (far - near), 0};
  std::array<float, 16> columns{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 3; ++j) columns[4 * j + i] = static_cast<float>(rows[i][j]);
    columns[12 + i] = static_cast<float>(constants[i] - dot(rows[i], eye_));
  }
  return columns;
}

}  // namespace odeval::render
