// What a mechanism says of itself, what a generator makes of a chain, and what a scenario asks of an engine.
#include "odeval/mechanism.hpp"

#include <map>
#include <set>

#include "catalogue/paths.hpp"
#include "model/find_scenario.hpp"
#include "model/read_scenario.hpp"
#include "tests/check.hpp"
#include "tests/scenarios.hpp"

namespace {

using namespace odeval;

constexpr double rounding = 1e-14;  // a few operations on numbers of order 1 to 10

// Carriers, contacts, attitudes -----------------------------------------------------------------------------------

Joint joint(std::size_t first, std::optional<std::size_t> second = {}) {
  return {.kind = BallJoint{}, .first = first, .second = second};
}

/// "1+": joint 1 tells the force on the body; "1-": on the other; "none".
std::string carrier(const std::vector<Joint>& joints, std::size_t body) {
  Mechanism mechanism;
  mechanism.bodies.resize(4);
  mechanism.joints = joints;
  const std::optional<Carrier> found = carrier_of(mechanism, body);
  return found ? std::to_string(found->joint) + (found->sign > 0 ? "+" : "-") : "none";
}

void a_body_has_the_force_of_its_carrier() {
  const std::vector<Joint> chain{joint(0), joint(0, 1), joint(1, 2)};
  CHECK_EQUAL(carrier(chain, 0), "0+");
  CHECK_EQUAL(carrier(chain, 1), "1+");
  CHECK_EQUAL(carrier(chain, 2), "2+");
  CHECK_EQUAL(carrier(chain, 3), "none");
  // Nothing carries the root of a pair in the air: it has the other's force, turned round.
  CHECK_EQUAL(carrier({joint(0, 1)}, 0), "0-");
  // What carries comes before what merely holds, whatever the order of the joints; of two that carry, the first.
  CHECK_EQUAL(carrier({joint(0, 1), joint(0)}, 0), "1+");
  const std::vector<Joint> loop{joint(0, 2), joint(1, 2)};
  CHECK_EQUAL(carrier(loop, 2), "0+");
  CHECK_EQUAL(carrier(loop, 1), "1-");
  CHECK_EQUAL(carrier({}, 0), "none");
}

void a_contact_is_between_whom_it_names() {
  const Contact any;
  CHECK(any.is_between("a", "b"));
  const Contact pair{.first = "a", .second = "b"};
  CHECK(pair.is_between("a", "b") && pair.is_between("b", "a"));
  CHECK(!pair.is_between("a", "c") && !pair.is_between("c", "b") && !pair.is_between("a", "a"));
  const Contact shape{.first = "b.foot", .second = "a"};
  CHECK(shape.is_between("b.foot", "a") && shape.is_between("a", "b.foot"));
  CHECK(!shape.is_between("b", "a") && !shape.is_between("b.foot2", "a") && !shape.is_between("b.head", "a"));
  CHECK(pair.is_between("a.head", "b") && pair.is_between("b.foot", "a.head"));
  CHECK(!pair.is_between("a2", "b") && !pair.is_between("a", "a.head") && any.is_between("a.head", "b"));
  for (const Contact& with_all : {Contact{.first = "a"}, Contact{.second = "a"}}) {
    CHECK(with_all.is_between("a", "b") && with_all.is_between("b", "a"));
    CHECK(!with_all.is_between("b", "c"));
  }
}

void attitudes_are_rotation_vectors() {
  const Vec3 vector{0.1, -4, 7};
  CHECK(rotation_vector(vector) == vector);
  const Vec3 turn = rotation_vector(AxisAngle{{0, 0.6, -0.8}, 10});  // more than a turn
  CHECK_EQUAL(turn[0], 0.0);
  CHECK_NEAR(turn[1], 6, rounding);
  CHECK_NEAR(turn[2], -8, rounding);
}

// The generator of chains ------------------------------------------------------------------------------------------

/// A direction of the body in the world, by Rodrigues' formula.
Vec3 turned(const Body& body, const Vec3& v) {
  const Vec3 turn = rotation_vector(body.attitude);
  const double angle = length(turn);
  if (angle == 0) return v;
  const Vec3 axis = unit(turn);
  return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + ((1 - std::cos(angle)) * dot(axis, v)) * axis;
}

Scenario chain_in(const PlanarFrame& frame, LinkShape shape, const std::vector<double>& q0) {
  Scenario scenario;
  put_planar(scenario, {frame,
                        {{1.5, 0.8, 0.1, 0.3, shape}, {0.5, 1.3, 0.2, 0.05, shape}, {2.0, 0.4, 0.15, 0.25, shape}},
                        q0,
                        {1.1, -2.3, 0.7},
                        {}});
  return scenario;
}

void check_near(const Vec3& actual, const Vec3& wanted, double tolerance) {
  CHECK_NEAR(distance(actual, wanted), 0, tolerance);
}

/// Hinges and centres of the links, walked along the plane by complex numbers.
struct Places {
  std::vector<Vec3> hinges;
  std::vector<Vec3> centres;
};

Places places_of(const PlanarView& view, const std::vector<double>& q) {
  Places places;
  double right = 0, up = 0, angle = 0;
  const auto point = [&](double r, double u) {
    return view.frame.hinge_m + r * view.frame.horizontal + u * view.frame.up;
  };
  for (std::size_t i = 0; i < q.size(); ++i) {
    const Link& link = view.links[i];
    angle += q[i];
    places.hinges.push_back(point(right, up));
    const double centre = link.shape == LinkShape::box ? link.length_m / 2 : link.length_m;
    places.centres.push_back(point(right + centre * std::cos(angle), up + centre * std::sin(angle)));
    right += link.length_m * std::cos(angle);
    up += link.length_m * std::sin(angle);
  }
  return places;
}

void check_link(const Body& body, const PlanarView& view, std::size_t i) {
  const PlanarFrame& frame = view.frame;
  const Link& link = view.links[i];
  CHECK_EQUAL(body.mass_kg, link.mass_kg);
  const double angle = view.q0[0] + (i > 0 ? view.q0[1] : 0) + (i > 1 ? view.q0[2] : 0);
  const double rate = view.qd0[0] + (i > 0 ? view.qd0[1] : 0) + (i > 1 ? view.qd0[2] : 0);
  const Vec3 along = std::cos(angle) * frame.horizontal + std::sin(angle) * frame.up;
  check_near(turned(body, frame.along_body), along, rounding);
  check_near(turned(body, frame.across_body), cross(frame.axis(), along), rounding);
  check_near(body.spin_rad_s, rate * frame.axis(), rounding);
  CHECK_EQUAL(is_sphere(body.shape), link.shape == LinkShape::sphere);
  const Vec3 sides = sides_m(body.shape);
  const auto side = [&](const Vec3& direction) { return std::fabs(dot(sides, direction)); };
  const bool box = link.shape == LinkShape::box;
  CHECK_EQUAL(side(frame.along_body), box ? link.length_m : link.width_m);
  CHECK_EQUAL(side(frame.across_body), link.width_m);
  CHECK_EQUAL(side(frame.hinge_axis), box ? link.depth_m : link.width_m);
  const Vec3 moments = body.uniform_moments_kgm2();
  CHECK_NEAR(std::fabs(dot(moments, frame.hinge_axis)), link.inertia_kgm2(), rounding);
  CHECK_NEAR(std::fabs(dot(moments, frame.along_body)), link.inertia_along_kgm2(), rounding);
  CHECK_NEAR(std::fabs(dot(moments, frame.across_body)), link.inertia_across_kgm2(), rounding);
}

void a_chain_stands_where_its_view_says(const PlanarFrame& frame, LinkShape shape) {
  const std::vector<double> q0{0.4, -1.2, 2.5};
  const Scenario scenario = chain_in(frame, shape, q0);
  const PlanarView& view = *scenario.planar;
  const Mechanism& mechanism = scenario.mechanism;
  CHECK_EQUAL(mechanism.bodies.size(), 3u);
  CHECK_EQUAL(mechanism.joints.size(), 3u);
  CHECK(mechanism.obstacles.empty() && mechanism.contacts.empty() && scenario.impact_views.empty());

  const Places now = places_of(view, q0);
  // Central differences over 1e-5 s: their own error 1e-9, and rounding of 1e-16 over 1e-5.
  constexpr double step = 1e-5;
  std::vector<double> before = q0, after = q0;
  for (std::size_t i = 0; i < 3; ++i) {
    before[i] -= step * view.qd0[i];
    after[i] += step * view.qd0[i];
  }
  const Places earlier = places_of(view, before), later = places_of(view, after);
  for (std::size_t i = 0; i < 3; ++i) {
    const Body& body = mechanism.bodies[i];
    check_near(body.position_m, now.centres[i], rounding);
    check_near(body.velocity_m_s, (1 / (2 * step)) * (later.centres[i] - earlier.centres[i]), 1e-8);
    check_link(body, view, i);

    const Joint& hinge = mechanism.joints[i];
    check_near(std::get<HingeJoint>(hinge.kind).anchor_m, now.hinges[i], rounding);
    CHECK(std::get<HingeJoint>(hinge.kind).axis == frame.hinge_axis);
    CHECK_EQUAL(hinge.carried(), i);
    CHECK(hinge.opening_m == Vec3{} && !hinge.motor && !hinge.stop);
    CHECK_EQUAL(hinge.second.has_value(), i > 0);
    CHECK_EQUAL(hinge.first, i > 0 ? i - 1 : 0);
  }
}

void a_wall_stands_at_its_face() {
  Scenario scenario = test::report_scenario("wall_pendulum", 1, 1e-3);
  change_planar(scenario, [](PlanarView& view) { view.wall = Wall{0.85, 0.25}; });
  const Mechanism& mechanism = scenario.mechanism;
  CHECK_EQUAL(mechanism.obstacles.size(), 1u);
  const FixedBox& box = std::get<FixedBox>(mechanism.obstacles.at(0).shape);
  CHECK_NEAR(box.centre_m[0] + box.sides_m[0] / 2, 0.85, rounding);
  CHECK_EQUAL(mechanism.contacts.at(0).restitution, 0.25);
  CHECK(!mechanism.contacts.at(0).friction);
  CHECK(mechanism.contacts.at(0).is_between("link1", mechanism.obstacles.at(0).name));
  CHECK_EQUAL(scenario.impact_views.size(), 1u);
  // Taken away again, nothing of it is left.
  change_planar(scenario, [](PlanarView& view) { view.wall.reset(); });
  CHECK(mechanism.obstacles.empty() && mechanism.contacts.empty() && scenario.impact_views.empty());
}

void a_slope_turns_its_impacts_as_well() {
  Description said;
  said.problem = &test::problem("bouncing_ball");
  said.bodies = {{.shape = BodyShape::sphere, .mass_kg = 1, .size_m = {0.1, 0.1, 0.1}, .position_m = {0, 0, 1}}};
  said.ground = GroundTable{};
  Scenario scenario;
  put_bodies(scenario, said);
  set_slope(scenario, 0.3);
  const Vec3 normal = std::get<HalfSpace>(scenario.mechanism.obstacles[0].shape).normal;
  CHECK_NEAR(normal[0], std::sin(0.3), 1e-16);
  CHECK(scenario.impact_views[0].normal == normal);
}

// Features ---------------------------------------------------------------------------------------------------------

/// Written again: a new feature does not compile without its words here.
std::string_view words_of(Feature feature) {
  switch (feature) {
    case Feature::space:
      return "bodies in space";
    case Feature::several_links:
      return "more than one link";
    case Feature::many_links:
      return "more than two links";
    case Feature::wall:
      return "contacts of a link";
    case Feature::wall_of_several:
      return "contacts of more than one link";
    case Feature::ground:
      return "contacts of bodies in space";
    case Feature::friction:
      return "friction";
    case Feature::constant_friction:
      return "friction of a constant force";
    case Feature::joints_in_space:
      return "joints of bodies in space";
    case Feature::open_joints:
      return "joints that start open";
    case Feature::motors:
      return "motors";
    case Feature::stops:
      return "stops";
    case Feature::bouncing_stops:
      return "stops that bounce";
    case Feature::loads:
      return "springs, torques and controllers of joints";
    case Feature::inertia:
      return "inertia tensors of their own";
    case Feature::loops:
      return "joints that close loops";
    case Feature::rare_joints:
      return "joints piston, pr, pu, hinge2 or plane2d";
    case Feature::struts:
      return "struts";
    case Feature::rare_shapes:
      return "contacts of cylinders, capsules or several shapes of a body";
    case Feature::axis_drives:
      return "motors, stops, springs, torques and controllers of joints with several motions";
    case Feature::cross_stops:
      return "stops of turns of joints universal and pu";
    case Feature::plane_motors:
      return "motors of joints plane2d";
    case Feature::soft_contacts:
      return "contacts with erp and cfm of their own";
    case Feature::sprung_contacts:
      return "contacts with kp and kd of their own";
  }
  return "";
}

void every_feature_has_a_name() {
  const auto names = feature_names();
  CHECK_EQUAL(std::set<std::string_view>(names.begin(), names.end()).size(), names.size());
  std::size_t count = 0;
  while (!words_of(static_cast<Feature>(count)).empty()) ++count;
  CHECK_EQUAL(names.size(), count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto feature = static_cast<Feature>(i);
    CHECK_EQUAL(names[i], words_of(feature));
    CHECK_EQUAL(listed(Features{feature}), std::string(words_of(feature)));
  }
  CHECK_EQUAL(listed({}), "");
  CHECK_EQUAL(listed({Feature::stops, Feature::friction}), "friction, stops");  // in the table's order
}

void files_ask_for_what_they_hold() {
  const std::map<std::string, Features> wanted{
      {"single_pendulum", {}},
      {"double_pendulum", {Feature::several_links}},
      {"iftomm_pendulum", {}},
      {"chain", {Feature::several_links, Feature::many_links}},
      {"wall_pendulum", {Feature::wall}},
      {"potra_pendulum", {Feature::several_links, Feature::wall, Feature::wall_of_several}},
      {"free_box", {Feature::space}},
      {"thin_body", {Feature::space}},
      {"bouncing_ball", {Feature::space, Feature::ground}},
      {"bouncing_balls", {Feature::space, Feature::ground}},
      {"friction_slide", {Feature::space, Feature::ground, Feature::friction}},
      {"spring_joint", {Feature::space, Feature::joints_in_space, Feature::open_joints}},
      {"open_hinge", {Feature::space, Feature::joints_in_space, Feature::open_joints}},
      {"three_link_arm", {Feature::space, Feature::joints_in_space, Feature::inertia}},
      {"buggy", {Feature::space, Feature::joints_in_space, Feature::rare_joints}},
      {"buggy_landing",
       {Feature::space, Feature::ground, Feature::friction, Feature::joints_in_space, Feature::rare_joints}},
      {"cart_pole",
       {Feature::space, Feature::joints_in_space, Feature::motors, Feature::stops, Feature::bouncing_stops,
        Feature::loads}},
      {"acrobot", {Feature::space, Feature::joints_in_space, Feature::loads, Feature::inertia}},
      {"iftomm_bricard", {Feature::space, Feature::joints_in_space, Feature::loops}},
      {"iftomm_four_bars", {Feature::space, Feature::joints_in_space, Feature::inertia, Feature::loops}},
      {"iftomm_governor", {Feature::space, Feature::joints_in_space, Feature::inertia, Feature::struts}},
      {"iftomm_squeezer",
       {Feature::space, Feature::joints_in_space, Feature::inertia, Feature::loads, Feature::loops, Feature::struts}},
      {"motor_lift", {Feature::space, Feature::joints_in_space, Feature::motors}},
      {"newtons_cradle", {Feature::space, Feature::ground, Feature::joints_in_space}},
      {"puma560", {Feature::space, Feature::joints_in_space, Feature::loads, Feature::inertia}},
      {"puma560_falling", {Feature::space, Feature::joints_in_space, Feature::inertia}},
  };
  Names names{catalogue::method_names(), {}};
  for (const Quantity& row : quantities) names.metrics.emplace_back(row.name);
  for (const std::string& name : scenario_names(catalogue::scenario_folder())) {
    const Scenario scenario = read_scenario(find_scenario(name, catalogue::scenario_folder()), {}, names);
    const auto found = wanted.find(name);
    test::report(found != wanted.end(), __FILE__, __LINE__, "no row for " + name);
    if (found != wanted.end())
      CHECK_EQUAL(name + ": " + listed(features_of(scenario)), name + ": " + listed(found->second));
  }
}

/// What no file can say yet.
void mechanisms_ask_for_what_they_hold() {
  const Scenario plain = test::report_scenario("single_pendulum", 1, 1e-3);
  CHECK(features_of(plain).empty());
  // Three links are as few as make many.
  CHECK(features_of(test::report_scenario("chain", 1, 1e-3)).has(Feature::many_links));
  CHECK_EQUAL(listed(Features{Feature::several_links, Feature::many_links}), "more than one link");
  Scenario driven = plain;
  driven.mechanism.joints[0].motor = Motor{};
  CHECK_EQUAL(listed(features_of(driven)), "motors");
  Scenario stopped = plain;
  stopped.mechanism.joints[0].stop = Stop{};
  CHECK_EQUAL(listed(features_of(stopped)), "stops");
  // On one of several motions these are asked for, and that as well; turns that cross have stops of their own.
  Scenario several = plain;
  Joint& joint = several.mechanism.joints[0];
  joint = {.kind = SlidingUniversalJoint{}, .first = joint.first, .second = joint.second};
  joint.drives = {{.motion = 0, .stop = Stop{}}};
  const std::string axis_drives = "motors, stops, springs, torques and controllers of joints with several motions";
  const std::string rare = "joints piston, pr, pu, hinge2 or plane2d, ";
  CHECK_EQUAL(listed(features_of(several)), "stops, " + rare + axis_drives);
  joint.drives[0].motion = 2;
  CHECK_EQUAL(listed(features_of(several)),
              "stops, " + rare + axis_drives + ", stops of turns of joints universal and pu");
  joint.kind = PlaneJoint{};
  joint.drives = {{.motion = 2, .motor = Motor{}}};
  CHECK_EQUAL(listed(features_of(several)), "motors, " + rare + axis_drives + ", motors of joints plane2d");
  Scenario heavy = plain;
  heavy.mechanism.bodies[0].inertia_kgm2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  CHECK_EQUAL(listed(features_of(heavy)), "inertia tensors of their own");
}

}  // namespace

int main() {
  a_slope_turns_its_impacts_as_well();
  a_body_has_the_force_of_its_carrier();
  a_contact_is_between_whom_it_names();
  attitudes_are_rotation_vectors();
  for (const Problem& problem : test::planar_problems()) {
    for (const LinkShape shape : {LinkShape::box, LinkShape::sphere}) {
      a_chain_stands_where_its_view_says(problem.frame, shape);
    }
  }
  a_wall_stands_at_its_face();
  every_feature_has_a_name();
  files_ask_for_what_they_hold();
  mechanisms_ask_for_what_they_hold();
  return test::verdict();
}
