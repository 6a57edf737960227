// Who knows the true motion of what: chosen by what a scenario is made of.
#include "reference/providers.hpp"

#include <functional>
#include <string>

#include "model/generate.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"

namespace {

using namespace odeval;
using Change = std::function<void(Scenario&)>;

const Body box{.shape = Box{{0.1, 0.2, 0.3}}, .mass_kg = 2};
const Body ball{.shape = Sphere{0.1}, .mass_kg = 2, .position_m = {0, 0, 1}};
const Joint pin{.kind = HingeJoint{}, .second = {}};

/// A build without Simbody knows no trees of bodies.
const bool with_trees = reference::mechanism_cvode != nullptr;

std::string method_for(const Scenario& scenario) { return std::string(reference::provider_for(scenario).method); }

Scenario of_bodies(std::vector<Body> bodies, std::vector<Joint> joints = {}) {
  Scenario scenario;
  scenario.file = "bodies.toml";
  scenario.mechanism.bodies = std::move(bodies);
  scenario.mechanism.joints = std::move(joints);
  return scenario;
}

Scenario on_plane(std::vector<Body> bodies, std::optional<Friction> friction) {
  Scenario scenario = of_bodies(std::move(bodies));
  scenario.mechanism.obstacles = {{HalfSpace{}, "ground"}};
  scenario.mechanism.contacts = {{.restitution = 0.5, .friction = friction}};
  return scenario;
}

Scenario chain(std::size_t links, LinkShape shape, std::optional<Wall> wall = {}) {
  Scenario scenario;
  scenario.file = "chain.toml";
  const std::vector<double> still(links);
  put_planar(scenario, {hanging_frame, {links, Link{1, 1, 0.1, 0.1, shape}}, still, still, wall});
  return scenario;
}

void what_is_known() {
  CHECK_EQUAL(method_for(of_bodies({box, ball})), "analytic");
  CHECK_EQUAL(method_for(of_bodies({box}, {pin})), "analytic");
  CHECK_EQUAL(method_for(of_bodies({box, box}, {Joint{.kind = BallJoint{}, .second = 1}})), "analytic");
  CHECK_EQUAL(method_for(on_plane({ball, ball}, {})), "analytic");
  Body swinging = box;
  swinging.position_m = {1, 0, 0};
  if (with_trees) CHECK_EQUAL(method_for(of_bodies({swinging}, {pin})), "mechanism-cvode");  // no spring's motion
  CHECK_EQUAL(method_for(on_plane({box}, Friction{0.3})), "analytic");
  for (const std::size_t links : {1U, 2U, 3U, 20U}) {
    for (const LinkShape shape : {LinkShape::box, LinkShape::sphere}) {
      CHECK_EQUAL(method_for(chain(links, shape)), "lagrange-cvode");  // of one link as well, which has a closed form
    }
  }
  CHECK_EQUAL(method_for(chain(1, LinkShape::box, Wall{-0.5, 1})), "lagrange-cvode");
  CHECK_EQUAL(method_for(chain(2, LinkShape::sphere, Wall{-0.5, 1})), "lagrange-cvode");
}

void refused(Scenario scenario, const Change& change, const char* why) {
  change(scenario);
  CHECK_THROWS(reference::provider_for(scenario), UserError, why);
}

void what_is_not() {
  const Change nothing = [](Scenario&) {};
  const Change motor = [](Scenario& s) { s.mechanism.joints[0].motor = Motor{1, 1}; };
  const Change stop = [](Scenario& s) { s.mechanism.joints[0].stop = Stop{-1, 1, 0}; };
  const Change tensor = [](Scenario& s) { s.mechanism.bodies[0].inertia_kgm2 = {1, 0, 0, 0, 1, 0, 0, 0, 1}; };
  const Change spring = [](Scenario& s) { s.mechanism.joints[0].springs = {{1, 0, 0}}; };
  const char* const together = "there is no reference for these bodies, joints and contacts together";
  refused(chain(2, LinkShape::box), motor, with_trees ? together : "there is no reference for what has motors");
  refused(of_bodies({}), nothing, together);
  const Change hung = [](Scenario& s) { s.mechanism.joints = {pin}; };
  const Change twice = [](Scenario& s) { s.mechanism.contacts.push_back(s.mechanism.contacts[0]); };
  const Change another = [](Scenario& s) { s.mechanism.contacts[0].first = "another"; };
  const Joint knee{.kind = BallJoint{}, .second = 1};
  const Joint back{.kind = BallJoint{}, .first = 1, .second = {}};  // which closes a loop
  for (const auto& [trees, change] :
       {std::pair{of_bodies({box}, {pin}), motor}, std::pair{of_bodies({box}, {pin}), stop},
        std::pair{of_bodies({box}, {pin}), spring}, std::pair{of_bodies({box}), tensor},
        std::pair{of_bodies({box, box}, {pin}), nothing}, std::pair{of_bodies({box, box}, {pin, knee}), nothing},
        std::pair{of_bodies({box}, {Joint{.kind = SliderJoint{}, .second = {}}}), nothing},
        std::pair{of_bodies({box, box}, {pin, knee, back}), nothing}, std::pair{on_plane({ball}, {}), hung},
        std::pair{on_plane({ball}, {}), twice}, std::pair{on_plane({ball}, {}), another}}) {
    if (with_trees) {
      Scenario scenario = trees;
      change(scenario);
      CHECK_EQUAL(method_for(scenario), "mechanism-cvode");
    } else {
      refused(trees, change, "there is no reference");
    }
  }
  // Joints that start open.
  refused(
      of_bodies({box, box}, {pin, knee}),
      [](Scenario& s) {
        s.mechanism.joints[1].opening_m = {0, 0, 0.1};
      },
      together);
  refused(chain(2, LinkShape::box), tensor,
          with_trees ? together : "there is no reference for what has inertia tensors of their own");
  refused(
      on_plane({ball}, {}), [](Scenario& s) { s.mechanism.obstacles[0].shape = FixedBox{}; }, together);
  refused(
      on_plane({box}, Friction{0.3}),
      [](Scenario& s) {
        s.mechanism.obstacles[0].shape = HalfSpace{{0, 0.6, 0.8}, 0};
      },
      together);
  refused(chain(3, LinkShape::sphere, Wall{-0.5, 1}), nothing, together);
  refused(chain(2, LinkShape::box, Wall{-0.5, 1}), nothing, together);
  refused(chain(1, LinkShape::sphere, Wall{-0.5, 1}), nothing, together);
  refused(
      chain(2, LinkShape::sphere, Wall{-0.5, 1}), [](Scenario& s) { s.mechanism.contacts[0].friction = Friction{0.3}; },
      together);
}

// Turned and moved as a whole, plane and ball keep their distance.
void a_plane_need_not_pass_through_the_origin() {
  Scenario scenario = on_plane({ball}, {});
  Scenario raised = scenario;
  raised.mechanism.obstacles[0].shape = HalfSpace{{0, 0, 1}, 2};
  raised.mechanism.bodies[0].position_m[2] += 2;
  const SampleGrid grid{0.125, 1, 21};
  const Reference low = reference::provider_for(scenario).solve(scenario, grid);
  const Reference high = reference::provider_for(raised).solve(raised, grid);
  CHECK_EQUAL(low.impacts.size(), high.impacts.size());
  for (std::size_t k = 0; k < 21; ++k) {
    CHECK_NEAR(high.trace.bodies[0].position[2][k] - low.trace.bodies[0].position[2][k], 2, 1e-14);
  }
}

}  // namespace

int main() {
  what_is_known();
  what_is_not();
  a_plane_need_not_pass_through_the_origin();
  return odeval::test::verdict();
}
