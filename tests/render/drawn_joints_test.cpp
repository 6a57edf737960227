// Joints are seen: of each hinge a pin along its axis, out of the bodies that it holds, with its centre line; a ball;
// a rail. They go with their bodies.
#include <cmath>

#include "odeval/error.hpp"
#include "render/studio.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

using namespace odeval;
using namespace odeval::render;

namespace {

const View front{0, 0, {}};  // x to the right, z up, from -y

/// Dark and without a colour, in a pixel or beside it: no body is, and the ground is light.
bool is_joint(const Image& image, const Pixel& at) {
  for (const int dx : {-1, 0, 1}) {
    for (const int dy : {-1, 0, 1}) {
      const Colour seen = image.at(static_cast<int>(at.x) + dx, static_cast<int>(at.y) + dy);
      const auto [least, most] = std::minmax({seen.r, seen.g, seen.b});
      if (most < 150 && most - least < 25) return true;
    }
  }
  return false;
}

/// A bar that hangs from the world on a joint at the origin, and below it, at z = -1, another on a hinge about x.
Scenario two_bars(const JointKind& upper) {
  Scenario scenario = odeval::test::report_scenario("free_box", 0.1, 1e-3);
  scenario.mechanism.bodies = {{.shape = Box{{0.2, 0.2, 1}}, .mass_kg = 1, .position_m = {0, 0, -0.5}},
                               {.shape = Box{{0.12, 0.12, 0.8}}, .mass_kg = 1, .position_m = {0, 0, -1.4}}};
  scenario.mechanism.joints = {Joint{.kind = upper, .first = 0, .second = {}},
                               Joint{.kind = HingeJoint{{0, 0, -1}, {1, 0, 0}}, .first = 1, .second = 0}};
  return scenario;
}

const Pose hanging{{{0, 0, -0.5}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, -1.4}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}}};
/// A quarter turn about y, by which z goes to x: both bars lie along -x, and the lower hinge's axis along z.
const Pose lying{{{-0.5, 0, 0}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {{-1.4, 0, 0}, {1, 0, 0}, {0, 0, -1}, {0, 1, 0}}};

struct Seen {
  Image image;
  Camera camera;

  bool operator()(const Vec3& point) const { return is_joint(image, camera.project(point)); }
};

Seen seen(const Scenario& scenario, const Pose& pose) {
  const std::vector<Pose> shown{pose};  // in the middle, where no nearer face hides what is beside a bar
  Studio studio(scenario, front, 900, 900, caption_font(), shown);
  const Tile above = studio.above_caption();
  return {studio.picture({pose, {}, ""}, {}), studio.camera(above.width, above.height)};
}

/// The lower pin stands out of the upper bar, which is the wider, on both sides along its axis, wherever that points,
/// and ends in its centre line; across its axis there is none.
void pins_go_with_their_bodies() {
  const Scenario scenario = two_bars(HingeJoint{{0, 0, 0}, {0, 1, 0}});
  const Seen hangs = seen(scenario, hanging);
  const Seen lies = seen(scenario, lying);
  for (const double side : {-1.0, 1.0}) {
    CHECK(hangs({side * 0.111, 0, -1}));
    CHECK(hangs({side * 0.15, 0, -1}));
    CHECK(!hangs({side * 0.25, 0, -1}));
    CHECK(!hangs({side * 0.111, 0, -0.9}));
    CHECK(lies({-1, 0, side * 0.111}));
    CHECK(lies({-1, 0, side * 0.15}));
    CHECK(!lies({-0.9, 0, side * 0.111}));
    CHECK(!lies({-1, 0, side * 0.25}));
  }
  // The upper one is looked at from its end, in front of its bar.
  for (const Seen* const one : {&hangs, &lies}) CHECK((*one)({0, -0.11, 0}));
  CHECK(!hangs({0, -0.11, -0.3}) && !lies({-0.3, -0.11, 0}));
}

void other_joints_have_marks_of_their_own() {
  const Seen ball = seen(two_bars(BallJoint{{0, 0, 0}}), hanging);
  CHECK(ball({0, 0, 0.03}));
  CHECK(!ball({0.111, 0, 0}) || !ball({0.15, 0, 0}));  // no pin
  const Seen slider = seen(two_bars(SliderJoint{{0, 0, 0}, {1, 0, 0}}), hanging);
  for (const double side : {-1.0, 1.0}) {
    CHECK(slider({side * 0.2, 0, 0}));
    CHECK(slider({side * 0.3, 0, 0}));
  }
  const Seen fixed = seen(two_bars(FixedJoint{{0, 0, 0}}), hanging);
  CHECK(!fixed({0, -0.11, 0}) && !fixed({0.111, 0, 0}) && !fixed({0, 0, 0.03}));
}

/// A robot's bodies have shapes of their own kinds, on another stage.
void bars_have_joints_as_well() {
  Scenario scenario = two_bars(HingeJoint{{0, 0, 0}, {0, 1, 0}});
  scenario.mechanism.bodies[0].shape = Cylinder{0.2, 1};
  const Seen hangs = seen(scenario, hanging);
  for (const double side : {-1.0, 1.0}) {
    CHECK(hangs({side * 0.111, 0, -1}) && hangs({side * 0.15, 0, -1}));
    CHECK(!hangs({side * 0.25, 0, -1}) && !hangs({side * 0.111, 0, -0.9}));
  }
}

}  // namespace

int main() {
  pins_go_with_their_bodies();
  other_joints_have_marks_of_their_own();
  bars_have_joints_as_well();
  return odeval::test::verdict();
}
