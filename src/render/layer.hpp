#pragma once
// What a painter paints: coloured triangles in the world, layer upon layer.
#include <vector>

#include "odeval/planar_view.hpp"
#include "render/image.hpp"

namespace odeval::render {

struct Vertex {
  float x, y, z;  // m, world frame
  Colour colour;
};

struct ClipPlane {  // normal . p >= offset
  Vec3 normal;
  double offset;
};

/// Triangles that share the way they meet what is painted already.
struct Layer {
  enum class Rule {
    over,   // covers whatever is there, as far as alpha says
    shade,  // takes its colour off what is there, from no pixel more than once, however many triangles lie on it
    solid,  // likewise covers, hidden behind nearer solids, and hides farther ones
  };
  Rule rule = Rule::solid;
  std::vector<Vertex> triangles;  // three by three
  std::vector<ClipPlane> within;  // paint only there; at most six
};

}  // namespace odeval::render
