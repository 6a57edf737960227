// Trees of bodies in generalized coordinates: against the planar Lagrangian, against the closed form of a free body,
// and beside ODE and the accurate step, which know nothing of generalized coordinates.
#include "reference/tree/tree_reference.hpp"

#include <array>
#include <functional>
#include <string>

#include "catalogue/accurate_method.hpp"
#include "odeval/error.hpp"
#include "reference/closed_form/body_solution.hpp"
#include "reference/closed_form/rotation.hpp"
#include "reference/planar/reference_solution.hpp"
#include "tests/check.hpp"
#include "tests/oracle/beside_reference.hpp"
#include "tests/random_mechanisms.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;
using namespace odeval::test;

// ---- The planar double pendulum as two hinges in space

void planar_pendulum() {
  const Scenario planar = test::report_scenario("double_pendulum", 3, 1e-3);
  Scenario space = planar;
  space.planar.reset();
  const SampleGrid grid{0.01, 1, 301};
  const Reference wanted = reference::solve_reference(planar, grid);
  const Reference tree = reference::solve_tree(space, grid);
  const PlanarFrame& frame = planar.planar->frame;
  double worst = 0;
  double largest_part = 0;
  double force = 0;
  for (std::size_t k = 0; k < tree.trace.rows(); ++k) {
    double angle = 0;
    double rate = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      angle += wanted.trace.q[i][k];
      rate += wanted.trace.qd[i][k];
      const BodyColumns& body = tree.trace.bodies[i];
      const Vec3 along = turned(row(body.rotation, k), frame.along_body);
      const double off = std::fabs(
          std::remainder(std::atan2(dot(along, frame.up), dot(along, frame.horizontal)) - angle, 2 * std::numbers::pi));
      worst = std::fmax(worst, off);
      const double stated = tree.uncertainty_turn[k] + static_cast<double>(i + 1) * wanted.uncertainty_q[k];
      if (k > 0) largest_part = std::fmax(largest_part, off / stated);
      CHECK_NEAR(dot(row(body.spin, k), frame.axis()), rate, 2e-9);
      force = std::fmax(force, distance(row(body.joint_force, k), row(wanted.joint_force[i], k)));
    }
  }
  std::printf("planar: %.3g rad apart, %.3g of what both state; forces %.3g N; stated to 3 s %.3g rad, %.3g m\n", worst,
              largest_part, force, tree.uncertainty_turn.back(), tree.uncertainty_position.back());
  CHECK_BETWEEN(worst, 0, 1e-9);
  CHECK_BETWEEN(largest_part, 0, 1);
  CHECK_BETWEEN(tree.uncertainty_turn.back(), 1e-14, 1e-9);
  CHECK_BETWEEN(force, 0, 1e-8);
}

// ---- Free bodies

Scenario free_bodies() {
  Scenario scenario;
  scenario.name = "free";
  scenario.duration_s = 3;
  scenario.mechanism.bodies = {
      Body{.shape = Box{{0.1, 0.4, 0.9}},
           .mass_kg = 10,
           .position_m = {1, 2, 3},
           .attitude = Vec3{0.3, -1, 2},
           .velocity_m_s = {-2, 2, 8},
           .spin_rad_s = {0.1, 5, 0.1}},
      Body{.shape = Sphere{0.3}, .mass_kg = 1, .velocity_m_s = {1, 0, 0}, .spin_rad_s = {3, 0, -4}}};
  return scenario;
}

/// What a state takes of what two references state together.
double largest_part(const Reference& a, const Reference& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.trace.bodies.size(); ++i) {
    const BodyColumns& one = a.trace.bodies[i];
    const BodyColumns& other = b.trace.bodies[i];
    for (std::size_t k = 0; k < a.trace.rows(); ++k) {
      const auto part = [&](double off, const Column& mine, const Column& its) {
        most = std::fmax(most, off / (mine[k] + its[k]));
      };
      part(distance(row(one.position, k), row(other.position, k)), a.uncertainty_position, b.uncertainty_position);
      part(apart(row(one.rotation, k), row(other.rotation, k)), a.uncertainty_turn, b.uncertainty_turn);
      part(distance(row(one.spin, k), row(other.spin, k)), a.uncertainty_spin, b.uncertainty_spin);
    }
  }
  return most;
}

void free_flight() {
  const Scenario scenario = free_bodies();
  const SampleGrid grid{0.01, 1, 301};
  const Reference wanted = reference::solve_body_reference(scenario, grid);
  const Reference tree = reference::solve_tree(scenario, grid);
  const double part = largest_part(tree, wanted);
  std::printf("free: %.3g of what both state, the tree to 3 s %.3g m, %.3g rad, %.3g rad/s\n", part,
              tree.uncertainty_position.back(), tree.uncertainty_turn.back(), tree.uncertainty_spin.back());
  CHECK_BETWEEN(part, 0, 1);
  CHECK_BETWEEN(tree.uncertainty_turn.back(), 1e-15, 1e-9);
}

void inertia_of_its_own() {
  Scenario scenario = free_bodies();
  scenario.mechanism.bodies.resize(1);
  scenario.mechanism.bodies[0].attitude = Vec3{};
  const SampleGrid grid{0.05, 1, 41};
  const Reference wanted = reference::solve_body_reference(scenario, grid);
  // The body's own axes turned by -turn in it, the body by the same the other way: the world sees the same motion.
  const Vec3 turn{0.7, -0.4, 1.1};
  scenario.mechanism.bodies[0] = in_axes(scenario.mechanism.bodies[0], reference::rotation_of(-1.0 * turn));
  scenario.mechanism.bodies[0].attitude = turn;
  const Reference tree = reference::solve_tree(scenario, grid);
  double most = 0;
  for (std::size_t k = 0; k < tree.trace.rows(); ++k) {
    most = std::fmax(most, distance(row(tree.trace.bodies[0].spin, k), row(wanted.trace.bodies[0].spin, k)));
  }
  std::printf("tensor: spin %.3g rad/s apart\n", most);
  CHECK_BETWEEN(most, 0, 2e-11);  // 2.3e-12 measured: the tensor's own rounding, which an unstable spin makes grow
}

/// One joint of a kind between a body that turns on the world and another, or on the world itself.
Scenario one_joint(std::size_t kind, bool on_world) {
  Random random(static_cast<unsigned>(kind) + 77);
  Scenario scenario = grown(1, 1);
  std::vector<Body>& bodies = scenario.mechanism.bodies;
  const Vec3 anchor = bodies[0].position_m + Vec3{0.3, -0.2, 0.4};
  if (on_world) {
    scenario.mechanism.joints = {{.kind = any_kind(random, kind, anchor), .first = 0, .second = {}}};
  } else {
    bodies.push_back(in_axes(bodies[0], reference::rotation_of(random.vector(1))));
    bodies[1].position_m = anchor + Vec3{0.1, 0.3, -0.3};
    scenario.mechanism.joints.push_back({.kind = any_kind(random, kind, anchor), .first = 0, .second = 1});
  }
  for (Body& body : bodies) {
    body.velocity_m_s = random.vector(1);
    body.spin_rad_s = random.vector(2);
  }
  fit_start(scenario.mechanism);
  return scenario;
}

void each_kind() {
  for (std::size_t kind = 0; kind < all_kinds; ++kind) {
    for (const bool on_world : {false, true}) {
      if (on_world && (kind == 4 || kind == 8)) continue;
      const Scenario scenario = one_joint(kind, on_world);
      const Reference reference = reference::solve_tree(scenario, rows_of(row_spacing_s));
      const double coarse = error(world_step(), scenario, reference, 2e-4);
      const double fine = error(world_step(), scenario, reference, 1e-4);
      const double rk = error(catalogue::make_accurate_4, scenario, reference, rk4_step_s);
      if (kind < kinds_that_converge) {
        CHECK_BETWEEN(observed_order(coarse, fine), 0.9, 1.1);
      } else {
        CHECK_BETWEEN(observed_order(coarse, fine), -0.1, 0.1);
      }
      CHECK_BETWEEN(rk, 0, 1e-9);
      std::printf("kind %zu%s: ODE %.3g -> %.3g (order %.3f), accurate step %.3g\n", kind,
                  on_world ? " on the world" : "", coarse, fine, observed_order(coarse, fine), rk);
    }
  }
}

// ---- Mistakes planted in what the reference is given, as a wrong sign or axis in its equations would be

void mistakes_are_seen() {
  const Scenario right = grown(5);
  const double known =
      error(catalogue::make_accurate_4, right, reference::solve_tree(right, rows_of(row_spacing_s)), rk4_step_s);
  using Plant = std::function<void(Scenario&)>;
  const auto plant = [&](const char* what, const Plant& mistake) {
    Scenario wrong = right;
    mistake(wrong);
    const Reference reference = reference::solve_tree(wrong, rows_of(row_spacing_s));
    const double off = error(catalogue::make_accurate_4, right, reference, rk4_step_s);
    const double order =
        observed_order(error(world_step(), right, reference, 2e-4), error(world_step(), right, reference, 1e-4));
    std::printf("%s: accurate step %.3g off, with the right reference %.3g; order of ODE %.2f\n", what, off, known,
                order);
    CHECK_BETWEEN(off, 1e3 * known, std::numeric_limits<double>::infinity());
  };
  plant("gravity upwards", [](Scenario& s) { s.gravity = -s.gravity; });
  plant("gravity 9.80", [](Scenario& s) { s.gravity = 9.80; });
  plant("products of inertia with the other sign", [](Scenario& s) {
    std::array<double, 9>& tensor = *s.mechanism.bodies[1].inertia_kgm2;
    for (const std::size_t k : {1, 2, 3, 5, 6, 7}) tensor[k] = -tensor[k];
  });
  plant("a mass 1e-4 heavier", [](Scenario& s) { s.mechanism.bodies.back().mass_kg *= 1 + 1e-4; });
  plant("an anchor 1e-5 m away", [](Scenario& s) {
    for (Joint& joint : s.mechanism.joints) {
      std::visit([](auto& kind) { kind.anchor_m[0] += 1e-5; }, joint.kind);
    }
    fit_start(s.mechanism);
  });
  plant("an axis turned by 1e-4", [](Scenario& s) {
    for (Joint& joint : s.mechanism.joints) {
      if (auto* const hinge = std::get_if<HingeJoint>(&joint.kind)) hinge->axis = unit(hinge->axis + Vec3{1e-4, 0, 0});
      if (auto* const slider = std::get_if<SliderJoint>(&joint.kind))
        slider->axis = unit(slider->axis + Vec3{1e-4, 0, 0});
    }
    fit_start(s.mechanism);
  });
}

// At loose tolerances the error is no rounding: it stays within what is stated, and both runs have their part in that.
void bound_covers() {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Scenario scenario = grown(seed);
    const SampleGrid grid = rows_of(row_spacing_s);
    const Reference known = reference::solve_tree(scenario, grid);
    const Reference loose = reference::solve_tree(scenario, grid, {1e-8, 1e-9}, {3e-7, 3e-8});
    const double part = largest_part(loose, known);
    std::printf("seed %u at rtol 1e-8: %.3g of what is stated, %.3g m\n", seed, part,
                loose.uncertainty_position.back());
    CHECK_BETWEEN(part, 0.01, 0.1);  // 0.03 to 0.07 measured; without the second run 0.13 to 0.5
  }
}

// A joint's axes and the first of its bodies: a universal joint told the other way round is the same joint.
void told_the_other_way_round() {
  Scenario scenario = grown(3);
  const Reference one = reference::solve_tree(scenario, rows_of(row_spacing_s));
  for (Joint& joint : scenario.mechanism.joints) {
    if (!joint.second) continue;
    joint = {.kind = joint.kind, .first = *joint.second, .second = joint.first};
    if (auto* const universal = std::get_if<UniversalJoint>(&joint.kind)) std::swap(universal->axis1, universal->axis2);
  }
  const Reference other = reference::solve_tree(scenario, rows_of(row_spacing_s));
  CHECK_BETWEEN(largest_part(one, other), 0, 1);
}

// ---- What a tree's reference tells

/// A body in the plane starts at the speed of its centre, wherever its joint has an anchor: it slides on straight.
void an_anchor_of_the_plane_is_nowhere() {
  Scenario scenario;
  scenario.name = "puck";
  scenario.mechanism.bodies = {{.shape = Box{{0.4, 0.3, 0.2}},
                                .mass_kg = 1,
                                .position_m = {1, 0, 0},
                                .velocity_m_s = {0.3, -0.2, 0},
                                .spin_rad_s = {0, 0, 2}}};
  scenario.mechanism.joints = {{.kind = PlaneJoint{}, .first = 0, .second = {}}};
  const Reference reference = reference::solve_tree(scenario, SampleGrid{0.01, 1, 51});
  constexpr double rounding = 1e-14;  // of numbers of size 1 over some steps
  CHECK_NEAR(reference.trace.bodies[0].position[0].back(), 1 + 0.3 * 0.5, rounding);
  CHECK_NEAR(reference.trace.bodies[0].position[1].back(), -0.2 * 0.5, rounding);
  CHECK_NEAR(reference.trace.bodies[0].spin[2].back(), 2, rounding);
}

void refusals() {
  Scenario scenario = grown(1);
  CHECK(reference::is_tree(scenario));
  Scenario loop = scenario;
  loop.mechanism.joints.push_back({.kind = BallJoint{}, .first = loop.mechanism.bodies.size() - 1, .second = {}});
  CHECK(reference::is_tree(loop));
  Scenario open = scenario;
  open.mechanism.joints[0].opening_m = {0, 0, 1e-3};
  CHECK(!reference::is_tree(open));
  Scenario touched = scenario;
  touched.mechanism.contacts = {{}};
  CHECK(!reference::is_tree(touched));
  scenario.mechanism.bodies[0].velocity_m_s = {1, 2, 3};
  CHECK_THROWS(reference::solve_tree(scenario, rows_of(row_spacing_s)), UserError, "does not allow the velocities");
}

}  // namespace

int main() {
  planar_pendulum();
  free_flight();
  inertia_of_its_own();
  each_kind();
  mistakes_are_seen();
  bound_covers();
  told_the_other_way_round();
  an_anchor_of_the_plane_is_nowhere();
  refusals();
  return test::verdict();
}
