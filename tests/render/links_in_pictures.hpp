#pragma once
// Links in pictures: where mathematics puts them, and whether a picture has their colours there.
#include <array>
#include <cmath>
#include <vector>

#include "catalogue/evaluation.hpp"
#include "render/studio.hpp"
#include "tests/check.hpp"

namespace odeval::test {

using render::Camera;
using render::Colour;
using render::Image;
using render::Pixel;
using render::Shot;
using render::View;

inline const View corner{30, 14, {}};
inline const View front{0, 0, {}};

/// Where a link is, from the angles of a trace: written again, so that it does not agree with pose.cpp by being it.
struct Segment {
  Vec3 near;
  Vec3 far;
  Vec3 across;
};

inline std::vector<Segment> segments(const Scenario& scenario, const Trace& trace, std::size_t row) {
  const PlanarFrame& frame = scenario.frame();
  std::vector<Segment> all;
  Vec3 near = frame.hinge_m;
  double angle = 0;
  for (std::size_t i = 0; i < scenario.planar->links.size(); ++i) {
    angle += trace.q[i][row];
    const double reach = scenario.planar->links[i].length_m;
    const Vec3 far = near + (reach * std::cos(angle)) * frame.horizontal + (reach * std::sin(angle)) * frame.up;
    all.push_back({near, far, -std::sin(angle) * frame.horizontal + std::cos(angle) * frame.up});
    near = far;
  }
  return all;
}

/// A point on the face of a link that looks along the axis; `s` from 0 at the near hinge to 1, `w` in widths aside.
inline Vec3 on_face(const Scenario& scenario, const Segment& segment, std::size_t link, double s, double w) {
  const Link& size = scenario.planar->links[link];
  return segment.near + s * (segment.far - segment.near) + (w * size.width_m) * segment.across +
         (0.48 * size.depth_m) * scenario.frame().axis();
}

/// Blue, orange: whatever the light, a link keeps the order and the distance of its colour's parts.
inline bool has_link_colour(const Image& image, const Pixel& at, std::size_t link) {
  const int x = static_cast<int>(at.x);
  const int y = static_cast<int>(at.y);
  if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return false;
  const Colour seen = image.at(x, y);
  return link == 0 ? seen.b > seen.r + 60 && seen.b > seen.g : seen.r > seen.g && seen.g > seen.b + 30;
}

inline long pixels_of_link(const Image& image, std::size_t link) {
  long count = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) count += has_link_colour(image, {x + 0.5, y + 0.5, 1}, link);
  }
  return count;
}

inline Shot shot_of(const Scenario& scenario, const Trace& trace, std::size_t row) {
  return {render::pose_at(scenario, trace, row), {}, "label"};
}

/// The links' axes in the picture, and what lies beside them.
inline void check_links(const Scenario& scenario, const Trace& trace, std::size_t row, const Image& scene,
                        const Camera& camera) {
  const std::vector<Segment> all = segments(scenario, trace, row);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto pixel = [&](double s, double w) { return camera.project(on_face(scenario, all[i], i, s, w)); };
    for (const double s : {0.15, 0.3, 0.5, 0.7, 0.85}) CHECK(has_link_colour(scene, pixel(s, 0), i));
    // The end points: 3 % before the far end is link unless a hinge lies there, 8 % behind it is none.
    if (i + 1 == all.size()) {
      CHECK(has_link_colour(scene, pixel(0.97, 0), i));
      CHECK(!has_link_colour(scene, pixel(1.08, 0), i));
    }
    for (const double w : {-1.8, 1.8}) CHECK(!has_link_colour(scene, pixel(0.5, w), i));
  }
}

}  // namespace odeval::test
