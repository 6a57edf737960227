#pragma once
// What stages share: ground, shadows, outlines, colours.
#include <array>
#include <functional>
#include <vector>

#include "render/brush.hpp"

namespace odeval::render {

inline constexpr double lamp_distance = 4;  // from what it lights, in the reach of the scene

inline constexpr Colour joint_colour{92, 94, 98};

/// 1, 2 or 5 times a power of ten, not above `most`.
double round_length(double most);

/// Of the body of that number.
Colour colour_in_turn(std::size_t body);

/// Of edges in a picture of the camera's size.
double edge_width_px(const Camera& camera);

using Quad = std::array<Vec3, 4>;  // corners in order around a flat face, to the left as seen from outside

void add_quads(std::vector<Quad>& quads, const LinkPose& box, const BoxSize& half);
void add_quads(std::vector<Quad>& quads, const Vec3& centre, double radius);  // of a sphere

struct GroundPlane {
  Vec3 middle;
  Vec3 u, v;  // unit, in the plane
  Vec3 normal;
};

/// A fading disc with a grid, 2.1 reaches wide.
void add_ground(std::vector<Layer>& layers, const Brush& brush, const Camera& camera, const GroundPlane& ground,
                double reach_m);

/// What the quads hide of a round lamp in the direction `towards_lamp` from a plane, within the half spaces.
void add_shadows(std::vector<Layer>& layers, const std::vector<Quad>& casters, const ClipPlane& plane,
                 const std::vector<ClipPlane>& within, const Vec3& towards_lamp);

/// A second pose's edges, with a halo, fainter where hidden. `wires` draws them into a layer.
void add_outline(std::vector<Layer>& layers, double edge_px,
                 const std::function<void(Layer&, const Colour&, double px)>& wires);

}  // namespace odeval::render
