#pragma once
// Shapes to triangles: lit faces, and lines of so many pixels.
#include <array>

#include "render/camera.hpp"
#include "render/layer.hpp"
#include "render/pose.hpp"

namespace odeval::render {

/// Half the sides of a link's box along its pose's directions, m.
struct BoxSize {
  double along;
  double across;
  double hinge;
};

using Corners = std::array<Vec3, 8>;  // bit 0: +along, bit 1: +across, bit 2: +hinge

Corners corners_of(const LinkPose& box, const BoxSize& half);

/// The two triangles of each of a box's six faces, with the face's outward normal.
struct Face {
  Vec3 normal;
  std::array<Vec3, 4> corners;  // in order around the face
};
std::array<Face, 6> faces_of(const LinkPose& box, const BoxSize& half);

Colour darker(const Colour& colour, double factor);

/// Adds shapes to layers as one camera sees them.
class Brush {
 public:
  /// `lamp` is where the light comes from, m.
  Brush(const Camera& camera, const Vec3& up, const Vec3& lamp) : camera_(camera), up_(up), lamp_(lamp) {}

  /// Faces in the light and, where `edge_px` > 0, the twelve edges in a darker tone.
  void box(Layer& layer, const LinkPose& box, const BoxSize& half, const Colour& colour, double edge_px) const;

  /// The twelve edges alone, in the given colour.
  void wire(Layer& layer, const LinkPose& box, const BoxSize& half, const Colour& colour, double edge_px) const;

  /// A closed cylinder about `axis`, a unit vector, with dark rims.
  void cylinder(Layer& layer, const Vec3& centre, const Vec3& axis, double radius, double half_length,
                const Colour& colour, double edge_px) const;

  /// A sphere with three great circles, which lie in the planes of its pose's directions and show how it turns.
  void sphere(Layer& layer, const LinkPose& pose, double radius, const Colour& colour, double edge_px) const;

  /// The three circles alone, in the given colour.
  void circles(Layer& layer, const LinkPose& pose, double radius, const Colour& colour, double edge_px) const;

  /// A straight line, `px` wide whatever its distance, a hair nearer to the eye than what it lies on.
  void line(Layer& layer, const Vec3& from, const Vec3& to, double px, const Colour& from_colour,
            const Colour& to_colour) const;

 private:
  Colour lit(const Colour& colour, const Vec3& point, const Vec3& normal) const;

  const Camera& camera_;
  Vec3 up_;
  Vec3 lamp_;
};

/// A corner of a triangle, in OpenGL's precision.
Vertex vertex(const Vec3& point, const Colour& colour);

/// Four corners in order around a flat face, as two triangles of one colour.
void add_quad(Layer& layer, const std::array<Vec3, 4>& corners, const std::array<Colour, 4>& colours);

}  // namespace odeval::render
