#include "render/brush.hpp"

#include <algorithm>
#include <numbers>

namespace odeval::render {
namespace {

constexpr int sides = 64;            // of a cylinder
constexpr double edge_shade = 0.42;  // of an edge, relative to its face

// Lines lie this much nearer to the eye: beside a face that recedes, half of a line's width would sink into it.
constexpr double line_lift = 1 - 1e-3;

// Half of the light comes from the lamp, the rest from a sky that is brighter above.
constexpr double ambient = 0.70;
constexpr double sky = 0.10;
constexpr double lamp_strength = 0.44;

std::uint8_t byte(double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0) + 0.5); }

}  // namespace

Colour darker(const Colour& colour, double factor) {
  return {byte(colour.r * factor), byte(colour.g * factor), byte(colour.b * factor), colour.a};
}

Vertex vertex(const Vec3& point, const Colour& colour) {
  return {static_cast<float>(point[0]), static_cast<float>(point[1]), static_cast<float>(point[2]), colour};
}

void add_quad(Layer& layer, const std::array<Vec3, 4>& corners, const std::array<Colour, 4>& colours) {
  for (const std::size_t k : {0U, 1U, 2U, 0U, 2U, 3U}) layer.triangles.push_back(vertex(corners[k], colours[k]));
}

Corners corners_of(const LinkPose& box, const BoxSize& half) {
  Corners corners;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const double along = (k & 1) != 0 ? half.along : -half.along;
    const double across = (k & 2) != 0 ? half.across : -half.across;
    const double hinge = (k & 4) != 0 ? half.hinge : -half.hinge;
    corners[k] = box.centre_m + along * box.along + across * box.across + hinge * box.hinge;
  }
  return corners;
}

std::array<Face, 6> faces_of(const LinkPose& box, const BoxSize& half) {
  const Corners c = corners_of(box, half);
  return {{{-1 * box.along, {c[0], c[2], c[6], c[4]}},
           {box.along, {c[1], c[3], c[7], c[5]}},
           {-1 * box.across, {c[0], c[1], c[5], c[4]}},
           {box.across, {c[2], c[3], c[7], c[6]}},
           {-1 * box.hinge, {c[0], c[1], c[3], c[2]}},
           {box.hinge, {c[4], c[5], c[7], c[6]}}}};
}

Colour Brush::lit(const Colour& colour, const Vec3& point, const Vec3& normal) const {
  const double facing = std::max(0.0, dot(normal, unit(lamp_ - point)));
  return darker(colour, ambient + sky * dot(normal, up_) + lamp_strength * facing);
}

void Brush::box(Layer& layer, const LinkPose& box, const BoxSize& half, const Colour& colour, double edge_px) const {
  for (const Face& face : faces_of(box, half)) {
    std::array<Colour, 4> colours;
    for (std::size_t k = 0; k < 4; ++k) colours[k] = lit(colour, face.corners[k], face.normal);
    add_quad(layer, face.corners, colours);
  }
  if (edge_px > 0) wire(layer, box, half, darker(colour, edge_shade), edge_px);
}

void Brush::wire(Layer& layer, const LinkPose& box, const BoxSize& half, const Colour& colour, double edge_px) const {
  const Corners corners = corners_of(box, half);
  for (std::size_t from = 0; from < corners.size(); ++from) {
    for (const std::size_t bit : {1U, 2U, 4U}) {
      if ((from & bit) == 0) line(layer, corners[from], corners[from | bit], edge_px, colour, colour);
    }
  }
}

void Brush::cylinder(Layer& layer, const Vec3& centre, const Vec3& axis, double radius, double half_length,
                     const Colour& colour, double edge_px) const {
  // Two directions at right angles to the axis, the first from the world axis the cylinder lies along least.
  const Vec3 least = std::fabs(axis[0]) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = unit(cross(axis, least));
  const Vec3 v = cross(axis, u);
  const auto spoke = [&](int k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    return std::cos(angle) * u + std::sin(angle) * v;
  };
  const Colour rim = darker(colour, edge_shade);
  for (const double end : {-1.0, 1.0}) {
    const Vec3 middle = centre + end * half_length * axis;
    for (int k = 0; k < sides; ++k) {
      const Vec3 a = middle + radius * spoke(k);
      const Vec3 b = middle + radius * spoke(k + 1);
      for (const Vec3& corner : {middle, a, b}) {
        layer.triangles.push_back(vertex(corner, lit(colour, corner, end * axis)));
      }
      if (edge_px > 0) line(layer, a, b, edge_px, rim, rim);
    }
  }
  for (int k = 0; k < sides; ++k) {
    const Vec3 a = centre + radius * spoke(k);
    const Vec3 b = centre + radius * spoke(k + 1);
    const Vec3 half = half_length * axis;
    const Colour at_a = lit(colour, a, spoke(k));
    const Colour at_b = lit(colour, b, spoke(k + 1));
    add_quad(layer, {a - half, b - half, b + half, a + half}, {at_a, at_b, at_b, at_a});
  }
}

void Brush::sphere(Layer& layer, const LinkPose& pose, double radius, const Colour& colour, double edge_px) const {
  constexpr int rings = sides / 2;
  const auto outward = [&](int ring, int spoke) {
    const double down = std::numbers::pi * ring / rings;
    const double around = 2 * std::numbers::pi * spoke / sides;
    return std::cos(down) * pose.along +
           std::sin(down) * (std::cos(around) * pose.across + std::sin(around) * pose.hinge);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int spoke = 0; spoke < sides; ++spoke) {
      const std::array<Vec3, 4> normals{outward(ring, spoke), outward(ring + 1, spoke), outward(ring + 1, spoke + 1),
                                        outward(ring, spoke + 1)};
      std::array<Vec3, 4> corners;
      std::array<Colour, 4> colours;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = pose.centre_m + radius * normals[k];
        colours[k] = lit(colour, corners[k], normals[k]);
      }
      add_quad(layer, corners, colours);
    }
  }
  if (edge_px > 0) circles(layer, pose, radius, darker(colour, edge_shade), edge_px);
}

void Brush::circles(Layer& layer, const LinkPose& pose, double radius, const Colour& colour, double edge_px) const {
  const auto circle = [&](const Vec3& u, const Vec3& v) {
    const auto at = [&](int k) {
      const double angle = 2 * std::numbers::pi * k / sides;
      return pose.centre_m + radius * (std::cos(angle) * u + std::sin(angle) * v);
    };
    for (int k = 0; k < sides; ++k) line(layer, at(k), at(k + 1), edge_px, colour, colour);
  };
  circle(pose.along, pose.across);
  circle(pose.across, pose.hinge);
  circle(pose.hinge, pose.along);
}

void Brush::line(Layer& layer, const Vec3& from, const Vec3& to, double px, const Colour& from_colour,
                 const Colour& to_colour) const {
  const Vec3& eye = camera_.eye();
  const Vec3 a = eye + line_lift * (from - eye);
  const Vec3 b = eye + line_lift * (to - eye);
  const Vec3 sideways = cross(b - a, eye - a);
  if (dot(sideways, sideways) == 0) return;  // seen end on
  const Vec3 direction = unit(b - a);
  const Vec3 aside = unit(sideways);
  const double wide_a = camera_.pixel_m(a) * px / 2;
  const double wide_b = camera_.pixel_m(b) * px / 2;
  const Vec3 start = a - wide_a * direction;  // longer by half the width, so that lines close at corners
  const Vec3 end = b + wide_b * direction;
  add_quad(layer, {start - wide_a * aside, end - wide_b * aside, end + wide_b * aside, start + wide_a * aside},
           {from_colour, to_colour, to_colour, from_colour});
}

}  // namespace odeval::render
