#include "render/stage.hpp"

#include <algorithm>
#include <array>
#include <numbers>

#include "render/vector.hpp"

namespace odeval::render {
namespace {

// Colours of links, in turn; Okabe and Ito's, which every kind of colour vision tells apart.
constexpr std::array palette{Colour{0, 114, 178},    // blue
                             Colour{230, 159, 0},    // orange
                             Colour{0, 158, 115},    // bluish green
                             Colour{204, 121, 167},  // reddish purple
                             Colour{86, 180, 233},   // sky blue
                             Colour{213, 94, 0}};    // vermilion
constexpr Colour hinge_colour{92, 94, 98};
constexpr Colour wall_colour{214, 208, 198};
constexpr Colour outline_colour{200, 0, 110};  // of no link, nor of any shadow
constexpr Colour halo_colour{255, 255, 255};   // on both sides of it
constexpr Colour ground_colour{222, 225, 229};
constexpr Colour grid_colour{168, 173, 180};

// A lamp of some size instead of a point makes soft shadows: the mean of sharp ones.
constexpr int lamp_points = 40;
constexpr double lamp_radius = 0.07;    // relative to its distance
constexpr Colour shadow_step{2, 2, 2};  // taken off for each point of the lamp that is hidden
constexpr double lamp_distance = 4;     // in reaches

/// 1, 2 or 5 times a power of ten, not above `most`.
double round_length(double most) {
  const double power = std::pow(10, std::floor(std::log10(most)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= most) return digit * power;
  }
  return power;
}

Colour faded(Colour colour, double cover) {
  colour.a = static_cast<std::uint8_t>(255 * std::clamp(cover, 0.0, 1.0) + 0.5);
  return colour;
}

/// From 1 in the middle to 0 at `radius`, without a visible rim.
double fade(double distance, double radius) {
  const double u = std::clamp(1 - distance / radius, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

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

Stage::Stage(const Scenario& scenario) : frame_(scenario.problem->frame), links_(scenario.links) {
  double lengths = 0;
  double widest = 0;
  for (const Link& link : links_) {
    lengths += link.length_m;
    widest = std::max(widest, link.width_m);
  }
  reach_m_ = lengths + widest / 2;
  ground_m_ = dot(frame_.hinge_m, frame_.up) - reach_m_ - lengths / 40;
  if (!scenario.wall) return;

  const double hinge_height = dot(frame_.hinge_m, frame_.up);
  const double top = hinge_height + reach_m_ / 2;
  const double thickness = 0.3 * reach_m_;
  const double depth = std::max(0.8 * reach_m_, 2 * links_.front().depth_m);
  const double middle = scenario.wall->face_m - thickness / 2 - dot(frame_.hinge_m, frame_.horizontal);
  const Vec3 centre = frame_.hinge_m + middle * frame_.horizontal + ((top + ground_m_) / 2 - hinge_height) * frame_.up;
  wall_ =
      Block{{centre, frame_.up, frame_.horizontal, frame_.axis()}, {(top - ground_m_) / 2, thickness / 2, depth / 2}};
}

std::vector<Vec3> Stage::extent() const {
  double depth = 0;
  for (const Link& link : links_) depth = std::max(depth, link.depth_m);
  std::vector<Vec3> points;
  const double face = wall_ ? dot(wall_->pose.centre_m, frame_.horizontal) + wall_->half.across : 0;
  for (int k = 0; k < 48; ++k) {
    const double angle = 2 * std::numbers::pi * k / 48;
    for (const double side : {-0.5, 0.5}) {
      Vec3 point = frame_.hinge_m + reach_m_ * (std::cos(angle) * frame_.horizontal + std::sin(angle) * frame_.up) +
                   side * depth * frame_.axis();
      if (wall_) point = point + std::max(0.0, face - dot(point, frame_.horizontal)) * frame_.horizontal;
      points.push_back(point);
    }
  }
  if (wall_) std::ranges::copy(corners_of(wall_->pose, wall_->half), std::back_inserter(points));
  return points;
}

Vec3 Stage::lamp() const {
  const Vec3 towards = unit(0.55 * frame_.horizontal + 0.75 * frame_.axis() + 1.1 * frame_.up);
  return frame_.hinge_m + lamp_distance * reach_m_ * towards;
}

bool Stage::drawable(const LinkPose& link) const {
  // Comparisons that are false for what is no number as well.
  const auto is_unit = [](const Vec3& v) { return std::fabs(dot(v, v) - 1) < 0.1; };
  const Vec3 away = link.centre_m - frame_.hinge_m;
  return dot(away, away) < 1e6 * reach_m_ * reach_m_ && is_unit(link.along) && is_unit(link.across) &&
         is_unit(link.hinge);
}

bool Stage::inside(const Camera& camera, const Pose& pose) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) return false;
    const Block link = block(pose, i);
    for (const Vec3& point : corners_of(link.pose, link.half)) {
      const Pixel at = camera.project(point);
      if (at.depth_m <= 0 || at.x < 0 || at.y < 0 || at.x > camera.width() || at.y > camera.height()) return false;
    }
  }
  return true;
}

// Links next to each other are drawn a little less deep in turn: faces in the same plane would fight for pixels.
Stage::Block Stage::block(const Pose& pose, std::size_t link) const {
  const Link& size = links_[link];
  if (size.shape == Shape::ball) return {pose[link], {size.width_m / 2, size.width_m / 2, size.width_m / 2}};
  const double depth = size.depth_m * (link % 2 == 0 ? 1 : 0.97);
  return {pose[link], {size.length_m / 2, size.width_m / 2, depth / 2}};
}

// What holds a ball, from its hinge to its centre: thin, but never too thin to see.
Stage::Block Stage::rod(const Pose& pose, std::size_t link) const {
  LinkPose middle = pose[link];
  const double half = links_[link].length_m / 2;
  middle.centre_m = middle.centre_m - half * middle.along;
  const double thin = std::max(0.1 * links_[link].width_m, 0.003 * reach_m_);
  return {middle, {half, thin, thin}};
}

void Stage::add_ground(std::vector<Layer>& layers, const Brush& brush, const Camera& camera) const {
  const double radius = 2.1 * reach_m_;
  const Vec3 middle = frame_.hinge_m + (ground_m_ - dot(frame_.hinge_m, frame_.up)) * frame_.up;
  const Vec3 u = frame_.horizontal;
  const Vec3 v = frame_.axis();

  Layer disc{Layer::Rule::over, {}, {}};
  constexpr int rings = 16;
  constexpr int spokes = 64;
  const auto at = [&](int ring, int spoke) {
    const double angle = 2 * std::numbers::pi * spoke / spokes;
    return middle + (radius * ring / rings) * (std::cos(angle) * u + std::sin(angle) * v);
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
  const double spacing = round_length(reach_m_ / 4);
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

void Stage::add_shadows(std::vector<Layer>& layers, const std::vector<Block>& casters, const HalfSpace& ground,
                        const std::vector<HalfSpace>& within) const {
  for (const Vec3& towards : lamp_directions(unit(lamp() - frame_.hinge_m))) {
    const double fall = dot(ground.normal, towards);
    Layer shadow{Layer::Rule::shade, {}, within};
    for (const Block& block : casters) {
      for (const Face& face : faces_of(block.pose, block.half)) {
        std::array<Vec3, 4> fallen = face.corners;
        for (Vec3& p : fallen) p = p - ((dot(ground.normal, p) - ground.offset) / fall) * towards;
        add_quad(shadow, fallen, {shadow_step, shadow_step, shadow_step, shadow_step});
      }
    }
    layers.push_back(std::move(shadow));
  }
}

void Stage::add_hinges(Layer& layer, const Brush& brush, const Pose& pose, double edge_px) const {
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const double thinnest = i == 0 ? links_[0].width_m : std::min(links_[i].width_m, links_[i - 1].width_m);
    const double deepest = i == 0 ? links_[0].depth_m : std::max(links_[i].depth_m, links_[i - 1].depth_m);
    // Never too small to see, nor so large that the hinges of a long chain hide its links.
    const double radius = std::max(0.32 * thinnest, std::min(0.004 * reach_m_, 0.1 * links_[i].length_m)) /
                          (links_[i].shape == Shape::ball ? 2 : 1);
    const Vec3 near = pose[i].centre_m - links_[i].centre_m() * pose[i].along;
    const Vec3 at = i == 0 ? frame_.hinge_m : near;
    // The first hinge holds on to the world; the others stand out so far that no edge is lifted over them.
    const double out = i == 0 ? 1.6 * radius : radius;
    brush.cylinder(layer, at, pose[i].hinge, radius, 0.5 * deepest + out, hinge_colour, edge_px);
  }
}

std::vector<Layer> Stage::layers(const Camera& camera, const Pose& pose, const Pose* outline) const {
  const Brush brush(camera, frame_.up, lamp());
  const double edge_px = std::max(0.9, camera.height() / 480.0);
  std::vector<Block> blocks;
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    blocks.push_back(block(pose, i));
    if (links_[i].shape == Shape::ball) blocks.push_back(rod(pose, i));
  }

  std::vector<Layer> layers;
  if (dot(camera.eye(), frame_.up) > ground_m_) {  // from below, the ground would hide all
    add_ground(layers, brush, camera);
    std::vector<Block> casters = blocks;
    if (wall_) casters.push_back(*wall_);
    add_shadows(layers, casters, {frame_.up, ground_m_}, {});
  }
  if (wall_) {
    Layer& wall = layers.emplace_back();
    brush.box(wall, wall_->pose, wall_->half, wall_colour, edge_px);
    const double face = dot(wall_->pose.centre_m, frame_.horizontal) + wall_->half.across;
    if (dot(camera.eye(), frame_.horizontal) > face) {
      const double side = dot(wall_->pose.centre_m, frame_.axis());
      const double top = dot(wall_->pose.centre_m, frame_.up) + wall_->half.along;
      add_shadows(layers, blocks, {frame_.horizontal, face},
                  {{frame_.axis(), side - wall_->half.hinge},
                   {-1 * frame_.axis(), -side - wall_->half.hinge},
                   {frame_.up, ground_m_},
                   {-1 * frame_.up, -top}});
    }
  }

  Layer& links = layers.emplace_back();
  for (std::size_t i = 0; i < pose.size(); ++i) {
    if (!drawable(pose[i])) continue;
    const Block link = block(pose, i);
    const Colour& colour = palette[i % palette.size()];
    if (links_[i].shape == Shape::ball) {
      const Block held_by = rod(pose, i);
      brush.box(links, held_by.pose, held_by.half, colour, 0);
      brush.ball(links, link.pose.centre_m, link.pose.hinge, link.half.hinge, colour, edge_px);
    } else {
      brush.box(links, link.pose, link.half, colour, edge_px);
    }
  }
  add_hinges(links, brush, pose, edge_px);

  if (outline != nullptr) {
    const auto add_wires = [&](Layer::Rule rule, const Colour& colour, double px) {
      Layer& wires = layers.emplace_back(Layer{rule, {}, {}});
      for (std::size_t i = 0; i < outline->size(); ++i) {
        if (!drawable((*outline)[i])) continue;
        const Block link = block(*outline, i);
        if (links_[i].shape == Shape::ball) {
          const Block held_by = rod(*outline, i);
          brush.wire(wires, held_by.pose, held_by.half, colour, px);
          brush.circle(wires, link.pose.centre_m, link.pose.hinge, link.half.hinge, colour, px);
        } else {
          brush.wire(wires, link.pose, link.half, colour, px);
        }
      }
    };
    add_wires(Layer::Rule::over, faded(halo_colour, 0.5), 2.4 * edge_px);
    add_wires(Layer::Rule::over, faded(outline_colour, 0.4), 1.4 * edge_px);  // fainter where hidden
    add_wires(Layer::Rule::solid, outline_colour, 1.4 * edge_px);
  }
  return layers;
}

}  // namespace odeval::render
