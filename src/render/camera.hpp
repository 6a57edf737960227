#pragma once
// From metres to pixels: the one place that knows how a point of the world lands in a picture.
#include <array>
#include <optional>
#include <span>

#include "odeval/planar_view.hpp"

namespace odeval::render {

/// From where a picture is taken.
struct View {
  double azimuth_deg = 0;            // 0: from the tip of the frame's axis; grows towards `horizontal`
  double elevation_deg = 0;          // above the level of the hinge
  std::optional<double> distance_m;  // from the first hinge, along the line of sight; absent: all fits
};

struct Pixel {
  double x;        // from the left edge of the picture
  double y;        // from its top edge
  double depth_m;  // in front of the eye
};

/// A rectangle of a picture, pixels.
struct Tile {
  int x;
  int y;
  int width;
  int height;
};

/// A perspective camera, upright, whose picture is `width` x `height` pixels.
class Camera {
 public:
  /// Looks at `frame` as `view` says and holds all of `points` with a margin.
  Camera(const PlanarFrame& frame, const View& view, std::span<const Vec3> points, int width, int height);

  Pixel project(const Vec3& point) const;

  /// World to OpenGL's clip coordinates for a part of the picture, by columns.
  std::array<float, 16> clip_matrix(const Tile& tile) const;

  const Vec3& eye() const { return eye_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Size of a pixel at a point, m.
  double pixel_m(const Vec3& point) const;

 private:
  Vec3 eye_;
  Vec3 right_;
  Vec3 up_;
  Vec3 forward_;
  double focal_;       // pixels
  double distance_m_;  // from the eye to the first hinge
  int width_;
  int height_;
};

}  // namespace odeval::render
