#include "render/scenery.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace odeval::render {
namespace {

// Okabe and Ito's, which every kind of colour vision tells apart.
constexpr std::array palette{Colour{0, 114, 178},    // blue
                             Colour{230, 159, 0},    // orange
                             Colour{0, 158, 115},    // bluish green
                             Colour{204, 121, 167},  // reddish purple
                             Colour{86, 180, 233},   // sky blue
                             Colour{213, 94, 0}};    // vermilion
constexpr Colour outline_colour{200, 0, 110};        // of no link, nor of any shadow
constexpr Colour halo_colour{255, 255, 255};         // on both sides of it
constexpr Colour ground_colour{222, 225, 229};
constexpr Colour grid_colour{168, 173, 180};

// A lamp of some size instead of a point makes soft shadows: the mean of sharp ones.
constexpr int lamp_points = 40;
constexpr double lamp_radius = 0.07;    // relative to its distance
constexpr Colour shadow_step{2, 2, 2};  // taken off for each point of the lamp that is hidden

Colour faded(Colour colour, double cover) {
  colour.a = static_cast<std::uint8_t>(255 * std::clamp(cover, 0.0, 1.0) + 0.5);
  return colour;
}

/// From 1 in the middle to 0 at `radius`, without a visible rim.
double fade(double distance, double radius) {
  const double u = std::clamp(1 - distance / radius, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

/// Whether the outer side of a quad looks that way. By its diagonals, since a sphere's at the poles are triangles.
bool faces(const Quad& quad, const Vec3& way) { return dot(cross(quad[2] - quad[0], quad[3] - quad[1]), way) > 0; }

/// Directions to points spread evenly over a round lamp that is seen towards `towards`.
std::vector<Vec3> lamp_directions(const Vec3& towards) {
  const Vec3 u = unit(cross(towards, std::fabs(towards[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}));
  const Vec3 v = cross(towards, u);
  std::vector<Vec3> directions;
  for (int k = 0; k < lamp_points; ++k) {
    const double radius = lamp_radius * std::sqrt((k + 0.5) / lamp_points);
    const double angle = k * std::numbers::pi * (3 - std::sqrt(5.0));
    directions.push_back(unit(towards + radius * (std::cos(angle) * u + std::sin(angle) * v)));
  }
  return directions;
}

}  // namespace

double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= most) return digit * power;
  }
  return power;
}

Colour colour_in_turn(std::size_t body) { return palette[body % palette.size()]; }

double edge_width_px(const Camera& camera) { return std::max(0.9, camera.height() / 480.0); }

void add_quads(std::vector<Quad>& quads, const LinkPose& box, const BoxSize& half) {
  for (const Face& face : faces_of(box, half)) {
    Quad& quad = quads.emplace_back(face.corners);
    if (!faces(quad, face.normal)) std::swap(quad[1], quad[3]);  // around its outer side
  }
}

void add_quads(std::vector<Quad>& quads, const Vec3& centre, double radius) {
  constexpr int rings = 12;
  constexpr int spokes = 24;
  const auto at = [&](int ring, int spoke) {
    const double down = std::numbers::pi * ring / rings;
    const double around = 2 * std::numbers::pi * spoke / spokes;
    return centre + radius * Vec3{std::sin(down) * std::cos(around), std::sin(down) * std::sin(around), std::cos(down)};
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int spoke = 0; spoke < spokes; ++spoke) {
      quads.push_back({at(ring, spoke), at(ring + 1, spoke), at(ring + 1, spoke + 1), at(ring, spoke + 1)});
    }
  }
}

void add_ground(std::vector<Layer>& layers, const Brush& brush, const Camera& camera, const GroundPlane& ground,
                double reach_m) {
  const double radius = 2.1 * reach_m;
  const auto& [middle, u, v, normal] = ground;

  Layer disc{Layer::Rule::over, {}, {}};
  constexpr int rings = 16;
  constexpr int spokes = 64;
  const auto at = [&](int ring, int spoke) {
    const double angle = 2 * std::numbers::pi * spoke / spokes;
    return ground.middle + (radius * ring / rings) * (std::cos(angle) * ground.u + std::sin(angle) * ground.v);
  };
  for (int ring = 0; ring < rings; ++ring) {
    const Colour inner = faded(ground_colour, fade(ring, rings));
    const Colour outer = faded(ground_colour, fade(ring + 1, rings));
    for (int spoke = 0; spoke < spokes; ++spoke) {
      add_quad(disc, {at(ring, spoke), at(ring, spoke + 1), at(ring + 1, spoke + 1), at(ring + 1, spoke)},
               {inner, inner, outer, outer});
    }
  }
  layers.push_back(std::move(disc));

  Layer grid{Layer::Rule::over, {}, {}};
  const double spacing = round_length(reach_m / 4);
  const double px = std::max(0.75, camera.height() / 750.0);
  const int lines = static_cast<int>(radius / spacing);
  constexpr int pieces = 40;
  for (int line = -lines; line <= lines; ++line) {
    const double aside = line * spacing;
    for (int piece = 0; piece < pieces; ++piece) {
      const double from = radius * (2.0 * piece / pieces - 1);
      const double to = radius * (2.0 * (piece + 1) / pieces - 1);
      const Colour first = faded(grid_colour, fade(std::hypot(aside, from), radius));
      const Colour second = faded(grid_colour, fade(std::hypot(aside, to), radius));
      if (first.a == 0 && second.a == 0) continue;
      brush.line(grid, middle + aside * u + from * v, middle + aside * u + to * v, px, first, second);
      brush.line(grid, middle + aside * v + from * u, middle + aside * v + to * u, px, first, second);
    }
  }
  layers.push_back(std::move(grid));
}

void add_shadows(std::vector<Layer>& layers, const std::vector<Quad>& casters, const ClipPlane& plane,
                 const std::vector<ClipPlane>& within, const Vec3& towards_lamp) {
  for (const Vec3& towards : lamp_directions(towards_lamp)) {
    const double fall = dot(plane.normal, towards);
    Layer shadow{Layer::Rule::shade, {}, within};
    for (Quad fallen : casters) {
      if (!faces(fallen, towards)) continue;  // of a closed surface the other half hides no more
      for (Vec3& p : fallen) p = p - ((dot(plane.normal, p) - plane.offset) / fall) * towards;
      add_quad(shadow, fallen, {shadow_step, shadow_step, shadow_step, shadow_step});
    }
    layers.push_back(std::move(shadow));
  }
}

void add_outline(std::vector<Layer>& layers, double edge_px,
                 const std::function<void(Layer&, const Colour&, double px)>& wires) {
  const auto add = [&](Layer::Rule rule, const Colour& colour, double px) {
    wires(layers.emplace_back(Layer{rule, {}, {}}), colour, px);
  };
  add(Layer::Rule::over, faded(halo_colour, 0.5), 2.4 * edge_px);
  add(Layer::Rule::over, faded(outline_colour, 0.4), 1.4 * edge_px);
  add(Layer::Rule::solid, outline_colour, 1.4 * edge_px);
}

}  // namespace odeval::render
