// Robots' files: what is made of them, and the proof that catches what an importer gets wrong.
#include "model/import_robot.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "catalogue/import_proof.hpp"
#include "engines/ode/module.hpp"
#include "model/mesh_box.hpp"
#include "model/read_scenario.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"
#include "tests/temporary_folder.hpp"

using namespace odeval;

namespace {

constexpr double half_turn = 3.14159265358979323846;

/// An arm with what importers get wrong: a fixed joint that turns, inertias in frames of their own, a joint that starts
/// in the middle of its limits, an axis against all others.
const std::string arm = R"(<robot name="arm">
  <link name="base"><inertial><mass value="9"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.3"/></geometry></collision></link>
  <link name="upper">
    <inertial><origin xyz="0.1 0.02 0.3" rpy="0.3 0.4 0.5"/><mass value="2"/>
      <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="-0.003"/></inertial>
    <collision name="skin"><origin xyz="0 0 0.25"/><geometry><box size="0.1 0.2 0.5"/></geometry></collision>
    <visual><geometry><box size="1 1 1"/></geometry></visual>
  </link>
  <link name="bracket">
    <inertial><origin xyz="0 0 0.1" rpy="0 0 1.0"/><mass value="0.5"/>
      <inertia ixx="0.002" iyy="0.003" izz="0.004" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="tube"><origin xyz="0 0 0.1"/><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
  <link name="mark"/>
  <link name="fore">
    <inertial><origin xyz="0.2 0 0" rpy="0 0.7 0"/><mass value="1"/>
      <inertia ixx="0.01" iyy="0.02" izz="0.025" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
  <link name="rod">
    <inertial><origin xyz="0 0 0.1"/><mass value="0.3"/>
      <inertia ixx="0.001" iyy="0.001" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 1" rpy="0 0 0.5"/>
    <axis xyz="0 3 0"/><limit lower="-1" upper="2" effort="5" velocity="1"/><dynamics damping="0.7" friction="0.2"/></joint>
  <joint name="weld" type="fixed"><parent link="upper"/><child link="bracket"/><origin xyz="0 0 0.5" rpy="1.1 0.2 -0.4"/></joint>
  <joint name="stuck" type="fixed"><parent link="bracket"/><child link="mark"/></joint>
  <joint name="elbow" type="revolute"><parent link="bracket"/><child link="fore"/><origin xyz="0.1 0 0.2" rpy="0.3 0 0"/>
    <axis xyz="1 0 -1"/><limit lower="0.4" upper="1.2" effort="0" velocity="0"/></joint>
  <joint name="pole" type="prismatic"><parent link="mark"/><child link="rod"/><origin xyz="0 0.3 0"/>
    <axis xyz="0 0 -1"/><limit lower="-0.5" upper="0.25" effort="0" velocity="0"/></joint>
</robot>)";

const std::string world = R"(<sdf version="1.7"><world name="yard">
  <gravity>0 0 -9.5</gravity>
  <physics type="ode"><max_step_size>0.002</max_step_size><ode>
    <solver><type>quick</type><iters>60</iters><sor>1.4</sor></solver>
    <constraints><cfm>1e-6</cfm><erp>0.3</erp><contact_max_correcting_vel>50</contact_max_correcting_vel>
      <contact_surface_layer>0.002</contact_surface_layer></constraints></ode></physics>
  <model name="ground"><static>true</static><link name="plane"><collision name="c"><geometry><plane/></geometry></collision></link></model>
  <model name="thing"><pose>0.5 0 2 0.1 0.2 0.3</pose>
    <link name="hull"><inertial><pose>0.1 0 0 0.4 0 0</pose><mass>2</mass>
      <inertia><ixx>0.02</ixx><iyy>0.03</iyy><izz>0.04</izz><ixy>0.001</ixy></inertia></inertial>
      <collision name="a"><geometry><capsule><radius>0.1</radius><length>0.3</length></capsule></geometry></collision>
      <collision name="b"><pose>0.2 0 0 0 0 0</pose><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>
    <link name="arm"><pose>0.3 0 0.2 0 0.5 0</pose><inertial><pose>0 0.1 0 0 0 0.2</pose><mass>0.5</mass>
      <inertia><ixx>0.002</ixx><iyy>0.003</iyy><izz>0.004</izz></inertia></inertial></link>
    <link name="head"><pose>0.3 0.1 0.4 0 0.5 0</pose><inertial><pose>0 0 0.1 0 0 0</pose><mass>0.3</mass>
      <inertia><ixx>0.001</ixx><iyy>0.0012</iyy><izz>0.0014</izz></inertia></inertial></link>
    <link name="cross"><pose>-0.3 0.1 0.4 0.2 0.5 0</pose><inertial><pose>0 0 0.1 0 0 0</pose><mass>0.3</mass>
      <inertia><ixx>0.001</ixx><iyy>0.0012</iyy><izz>0.0014</izz></inertia></inertial></link>
    <joint name="elbow" type="revolute"><pose>0 -0.05 0 0.3 0 0</pose><parent>hull</parent><child>arm</child>
      <axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper></limit><dynamics><damping>0.1</damping>
        <spring_reference>0.2</spring_reference><spring_stiffness>3</spring_stiffness></dynamics></axis></joint>
    <joint name="neck" type="ball"><parent>arm</parent><child>head</child></joint>
    <joint name="gimbal" type="universal"><parent>hull</parent><child>cross</child>
      <axis><xyz>1 0 0</xyz><limit><lower>1</lower><upper>2</upper></limit><dynamics><damping>0.3</damping></dynamics></axis>
      <axis2><xyz>0 1 0</xyz><limit><lower>-0.5</lower><upper>1.5</upper></limit><dynamics><friction>0.2</friction>
        <spring_reference>0.1</spring_reference><spring_stiffness>4</spring_stiffness></dynamics></axis2></joint>
  </model></world></sdf>)";

/// Everything stands in a frame of its own: of the world, of a link, of a model in the model, on a collision as well.
const std::string frames = R"(<sdf version="1.9"><world name="w">
  <frame name="table"><pose>1 2 0.5 0 0 1.5707963267948966</pose></frame>
  <model name="m"><pose relative_to="table">0 0 1 0 0 0</pose>
    <frame name="mount" attached_to="base"><pose relative_to="base">0 0 0.5 1.5707963267948966 0 0</pose></frame>
    <link name="base"><pose>0.1 0 0 0 0 0.7853981633974483</pose><inertial><mass>1</mass></inertial></link>
    <link name="arm"><pose relative_to="mount">0.2 0 0 0 0 0</pose><inertial><pose>0 0.1 0 0 0 0</pose><mass>2</mass>
      <inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.25</izz></inertia></inertial>
      <collision name="c"><pose relative_to="base">0 0 1 0 0 0</pose>
        <geometry><box><size>0.1 0.2 0.3</size></box></geometry></collision></link>
    <model name="inner"><pose relative_to="arm">0.3 0 0 0 0 0</pose>
      <link name="tip"><pose>0 0 0.1 0 0 0</pose><inertial><mass>0.5</mass></inertial></link></model>
    <joint name="foot" type="fixed"><parent>world</parent><child>base</child></joint>
    <joint name="hip" type="revolute"><pose relative_to="mount">0 0 0.1 0 0 0</pose><parent>mount</parent>
      <child>arm</child><axis><xyz expressed_in="base">0 0 1</xyz></axis></joint>
    <joint name="rail" type="prismatic"><parent>arm</parent><child>inner::tip</child>
      <axis><xyz expressed_in="__model__">1 0 0</xyz></axis></joint>
  </model></world></sdf>)";

/// Alone, and placed by a link that is not its first; with the elder word for an axis along the model's axes.
const std::string placed = R"(<sdf version="1.6"><model name="m" placement_frame="hand">
  <pose>0 0 1 0 1.5707963267948966 0</pose>
  <link name="base"><inertial><mass>1</mass></inertial></link>
  <link name="hand"><pose>0.5 0 0 0 0 0.3</pose><inertial><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>
  <joint name="wrist" type="revolute"><parent>base</parent><child>hand</child>
    <axis><xyz>0 1 0</xyz><use_parent_model_frame>true</use_parent_model_frame></axis></joint>
</model></sdf>)";

const Names names{{"ode-step-double", "ode-quickstep-double"}, {}};

bool reads(const char* format) {
#if ODEVAL_WITH_URDF
  if (format == std::string("URDF")) return true;
#endif
#if ODEVAL_WITH_SDFORMAT
  if (format == std::string("SDFormat")) return true;
#endif
  std::printf("skipped: this build reads no %s\n", format);
  return false;
}

Scenario scenario_of(const Imported& imported, const char* file) {
  return ScenarioFile(file, imported.toml).read({}, names);
}

/// Of the robot as it is when the importer is given another, and so makes that mistake.
ImportProof mistaken(const char* file, const Robot& robot, const Robot& given, const ImportOptions& options = {}) {
  Imported imported = import_robot(file, given, options);
  const Scenario scenario = scenario_of(imported, file);
  const std::vector<Robot::Joint> started = imported.robot.joints;
  imported.robot = robot;
  for (std::size_t i = 0; i < started.size(); ++i) imported.robot.joints[i].start = started[i].start;
  imported.robot.joints.front().kind = started.front().kind;  // as --base asks
  return catalogue::prove_import(imported, scenario);
}

const Body& body(const Scenario& scenario, std::string_view name) {
  for (const Body& one : scenario.mechanism.bodies) {
    if (one.name == name) return one;
  }
  throw std::runtime_error("no body " + std::string(name));
}
const Joint& joint(const Scenario& scenario, std::string_view name) {
  for (const Joint& one : scenario.mechanism.joints) {
    if (one.name == name) return one;
  }
  throw std::runtime_error("no joint " + std::string(name));
}

void check_near(const Vec3& actual, const Vec3& wanted, double tolerance) {
  for (std::size_t k = 0; k < 3; ++k) CHECK_NEAR(actual[k], wanted[k], tolerance);
}

void an_arm_is_what_its_file_says() {
  const Imported imported = import_robot("arm.urdf", read_robot("arm.urdf", arm), {});
  const Scenario scenario = scenario_of(imported, "arm.urdf");
  CHECK_EQUAL(scenario.mechanism.bodies.size(), 3u);  // base stands, bracket and mark are parts of upper
  CHECK_EQUAL(scenario.mechanism.joints.size(), 3u);
  // By hand: turned by 0.5 about z at (0, 0, 1); the centre of two masses, the second turned by the weld.
  const Body& upper = body(scenario, "upper");
  CHECK_EQUAL(upper.mass_kg, 2.5);
  const double cx = std::cos(1.1), sx = std::sin(1.1), cy = std::cos(0.2), sy = std::sin(0.2), cz = std::cos(-0.4),
               sz = std::sin(-0.4);
  // The third column of Rz(yaw) Ry(pitch) Rx(roll).
  const Vec3 up{cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx};
  const Vec3 bracket = Vec3{0, 0, 0.5} + 0.1 * up;
  const Vec3 centre = 0.4 * (2.0 * Vec3{0.1, 0.02, 0.3} + 0.5 * bracket);
  const double c = std::cos(0.5), s = std::sin(0.5);
  constexpr double rounding = 1e-15;  // of sums of a few numbers of size 1
  check_near(upper.position_m, {c * centre[0] - s * centre[1], s * centre[0] + c * centre[1], 1 + centre[2]}, rounding);
  check_near(rotation_vector(upper.attitude), {0, 0, 0.5}, rounding);

  // Its shapes: a box of its own, and the bracket's cylinder, turned by the weld.
  CHECK_EQUAL(upper.parts().size(), 2u);
  check_near(std::get<Box>(upper.parts()[0].shape).sides_m, {0.1, 0.2, 0.5}, 0);
  check_near(upper.parts()[0].place.position_m, Vec3{0, 0, 0.25} - centre, rounding);
  CHECK_EQUAL(std::get<Cylinder>(upper.parts()[1].shape).diameter_m, 0.1);
  CHECK_EQUAL(std::get<Cylinder>(upper.parts()[1].shape).length_m, 0.3);
  check_near(upper.parts()[1].place.position_m, bracket - centre, rounding);
  check_near(axis_of(upper.parts()[1].place.rotation, 2), up, 4 * rounding);
  CHECK_EQUAL(upper.touches_as(upper.parts()[0]), "upper.skin");
  CHECK_EQUAL(upper.touches_as(upper.parts()[1]), "upper.tube");
  CHECK_EQUAL(body(scenario, "fore").parts().size(), 1u);  // has none: the box that has its moments

  const Joint& shoulder = joint(scenario, "shoulder");
  check_near(std::get<HingeJoint>(shoulder.kind).axis, {-s, c, 0}, rounding);
  CHECK_EQUAL(shoulder.stop->low, -1.0);
  CHECK_EQUAL(shoulder.stop->high, 2.0);
  CHECK_EQUAL(shoulder.motor->speed, 0.0);
  CHECK_EQUAL(shoulder.motor->most, 0.2);
  CHECK_EQUAL(shoulder.springs.front().damping, 0.7);
  const Joint& elbow = joint(scenario, "elbow");  // starts at 0.8; told of the second body against the first
  CHECK_NEAR(elbow.stop->low, -0.4, rounding);
  CHECK_NEAR(elbow.stop->high, 0.4, rounding);
  CHECK(std::holds_alternative<SliderJoint>(joint(scenario, "pole").kind));
  CHECK_EQUAL(scenario.mechanism.bodies[*elbow.second].name, "fore");
  CHECK_EQUAL(scenario.mechanism.bodies[elbow.first].name, "upper");

  std::map<std::string, std::size_t> names_of;
  for (const Robot::Remark& remark : imported.robot.remarks) names_of[remark.what] += remark.of.size();
  CHECK_EQUAL(names_of["effort limits"], 1u);
  CHECK_EQUAL(names_of["fixed joints"], 2u);
  CHECK_EQUAL(names_of["start"], 1u);
  CHECK_EQUAL(names_of["mass"], 1u);
  CHECK_EQUAL(names_of["collision shapes"], 3u);  // of upper and bracket, and left out of base, which stands
  const auto left_out = std::ranges::find_if(imported.robot.remarks, [](const Robot::Remark& remark) {
    return remark.what == "collision shapes" && remark.rule == "not taken: the link stands in the world";
  });
  CHECK(left_out != imported.robot.remarks.end() && left_out->of == std::vector<std::string>{"base"});
  CHECK(names_of.contains("<link/visual>"));
}

/// Told of the hull against the cross; limits that 0 is outside of are left out.
void check_gimbal(const Imported& imported, const Joint& gimbal) {
  CHECK(std::holds_alternative<UniversalJoint>(gimbal.kind));
  CHECK_EQUAL(gimbal.drives.size(), 2u);
  const AxisDrive& first = gimbal.drives.front();
  CHECK_EQUAL(first.motion, 0u);
  CHECK(!first.stop && !first.motor && first.springs.size() == 1);
  CHECK_EQUAL(first.springs.front().damping, 0.3);
  const AxisDrive& second = gimbal.drives.back();
  CHECK_EQUAL(second.motion, 1u);
  CHECK_EQUAL(second.stop->low, -1.5);
  CHECK_EQUAL(second.stop->high, 0.5);
  CHECK_EQUAL(second.motor->most, 0.2);
  CHECK_EQUAL(second.springs.front().stiffness, 4.0);
  CHECK_EQUAL(second.springs.front().rest, -0.1);
  const auto left_out =
      std::ranges::find_if(imported.robot.remarks, [](const Robot::Remark& remark) { return remark.what == "limits"; });
  CHECK(left_out != imported.robot.remarks.end() && left_out->of == std::vector<std::string>{"thing::gimbal"});
  // What is taken is not told to be left out.
  for (const Robot::Remark& remark : imported.robot.remarks) CHECK(!remark.what.starts_with("<model/joint/axis"));
}

void a_world_is_what_its_file_says() {
  const Imported imported = import_robot("world.sdf", read_robot("world.sdf", world), {});
  const Scenario scenario = scenario_of(imported, "world.sdf");
  CHECK_EQUAL(scenario.mechanism.bodies.size(), 4u);
  CHECK_EQUAL(scenario.mechanism.joints.size(), 3u);  // the hull flies
  CHECK_EQUAL(scenario.step_s, 0.002);
  CHECK_EQUAL(scenario.gravity, 9.5);
  CHECK_EQUAL(scenario.ode.iterations, 60);
  CHECK_EQUAL(scenario.ode.sor_w, 1.4);
  CHECK_EQUAL(scenario.ode.erp, 0.3);
  CHECK_EQUAL(scenario.ode.cfm, 1e-6);
  CHECK_EQUAL(scenario.ode.max_correcting_vel, 50.0);
  CHECK_EQUAL(scenario.ode.surface_layer, 0.002);
  CHECK_EQUAL(scenario.methods.front(), "ode-quickstep-double");
  const Joint& elbow = joint(scenario, "thing__elbow");
  CHECK_EQUAL(elbow.stop->high, 1.0);  // of the hull against the arm
  CHECK_EQUAL(elbow.springs.front().stiffness, 3.0);
  CHECK_EQUAL(elbow.springs.front().rest, -0.2);
  CHECK(std::holds_alternative<BallJoint>(joint(scenario, "thing__neck").kind));
  check_gimbal(imported, joint(scenario, "thing__gimbal"));
  const Body& hull = body(scenario, "thing__hull");
  CHECK_EQUAL(hull.mass_kg, 2.0);
  // An SDFormat capsule's length is without its ends; both shapes stand against the centre of mass at x = 0.1.
  CHECK_EQUAL(hull.parts().size(), 2u);
  CHECK_EQUAL(std::get<Capsule>(hull.parts()[0].shape).diameter_m, 0.2);
  CHECK_EQUAL(std::get<Capsule>(hull.parts()[0].shape).length_m, 0.5);
  check_near(hull.parts()[0].place.position_m, {-0.1, 0, 0}, 1e-15);
  CHECK_EQUAL(std::get<Sphere>(hull.parts()[1].shape).diameter_m, 0.2);
  check_near(hull.parts()[1].place.position_m, {0.1, 0, 0}, 1e-15);
  CHECK(hull.parts()[0].name == "a" && hull.parts()[1].name == "b");
}

std::size_t told(const Imported& imported, const std::string& what) {
  std::size_t count = 0;
  for (const Robot::Remark& remark : imported.robot.remarks) count += remark.what == what ? 1 : 0;
  return count;
}

/// By hand. The table is turned by 90 degrees about z, base by 45 more, mount by 90 about the x that it then has, so
/// that its y points up; arm stands 0.2 along mount's x, and its centre 0.1 along its y.
void frames_are_followed() {
  const Imported imported = import_robot("frames.sdf", read_robot("frames.sdf", frames), {});
  const Scenario scenario = scenario_of(imported, "frames.sdf");
  constexpr double rounding = 4e-15;  // of some ten products of numbers up to 3
  const double r = std::sqrt(0.5);
  const Vec3 x{-r, r, 0};  // of mount, arm and tip
  const Vec3 z{r, r, 0};
  const Vec3 arm_at = Vec3{1, 2.1, 2} + 0.2 * x;
  const Body& hung = body(scenario, "arm");
  check_near(hung.position_m, arm_at + Vec3{0, 0, 0.1}, rounding);
  const Rotation turned_by = rotation_of_vector(rotation_vector(hung.attitude));
  check_near(axis_of(turned_by, 0), x, rounding);
  check_near(axis_of(turned_by, 1), {0, 0, 1}, rounding);
  check_near(turned(turned_by, hung.parts().at(0).place.position_m), Vec3{1, 2.1, 2.5} - hung.position_m, rounding);
  check_near(body(scenario, "inner__tip").position_m, arm_at + 0.3 * x + 0.1 * z, rounding);
  const auto& hip = std::get<HingeJoint>(joint(scenario, "hip").kind);
  check_near(hip.anchor_m, Vec3{1, 2.1, 2} + 0.1 * z, rounding);
  check_near(hip.axis, {0, 0, 1}, rounding);
  check_near(std::get<SliderJoint>(joint(scenario, "rail").kind).axis, {0, 1, 0}, rounding);
  CHECK_EQUAL(told(imported, "<frame>"), 0u);
  CHECK_EQUAL(told(imported, "links without <inertia>"), 1u);
}

void a_model_stands_by_its_placement_frame() {
  const Imported imported = import_robot("placed.sdf", read_robot("placed.sdf", placed), {});
  const Scenario scenario = scenario_of(imported, "placed.sdf");
  constexpr double rounding = 4e-15;  // as above
  const Body& hand = body(scenario, "hand");
  check_near(hand.position_m, {0, 0, 1}, rounding);
  check_near(axis_of(rotation_of_vector(rotation_vector(hand.attitude)), 0), {0, 0, -1}, rounding);
  // The model stands turned by -0.3 about the hand's z, which is the world's x.
  const double c = std::cos(0.3), s = std::sin(0.3);
  check_near(body(scenario, "base").position_m, {0, 0.5 * s, 1 + 0.5 * c}, rounding);
  check_near(std::get<HingeJoint>(joint(scenario, "wrist").kind).axis, {0, c, -s}, rounding);
  CHECK_EQUAL(told(imported, "<model/joint/axis/use_parent_model_frame>"), 0u);
  CHECK_EQUAL(told(imported, "links without <inertia>"), 1u);
  CHECK_EQUAL(told(imported, "links without <mass>"), 1u);
}

/// A model that is included keeps its axes, or is refused: until 1.4 they lie along those of the model, later along the
/// joint's.
void an_included_model_keeps_its_axes() {
  const test::TemporaryFolder folder;
  const auto write = [&](const char* name, const std::string& text) { std::ofstream(folder.path() / name) << text; };
  const auto axis_of_model = [&](const char* of_model, const char* of_world, const char* word) {
    write("part.sdf", std::string("<sdf version=\"") + of_model + R"("><model name="part">
      <link name="a"><inertial><mass>1</mass></inertial></link>
      <link name="b"><pose>0 0 1 0 0 1.5707963267948966</pose><inertial><mass>1</mass></inertial></link>
      <joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz>)" +
                          word + "</axis></joint></model></sdf>");
    write("world.sdf", std::string("<sdf version='") + of_world +
                           "'><world name='w'><include><uri>part.sdf</uri></include></world></sdf>");
    const Imported imported = import_robot(folder.path() / "world.sdf", {});
    return std::get<HingeJoint>(joint(scenario_of(imported, "world.sdf"), "j").kind).axis;
  };
  const char* const in_model = "<use_parent_model_frame>1</use_parent_model_frame>";
  const char* const refused = "which tell the axes of joints otherwise; write both in one";
  constexpr double rounding = 1e-15;  // of a quarter turn's sine and cosine
  check_near(axis_of_model("1.4", "1.4", ""), {1, 0, 0}, rounding);
  check_near(axis_of_model("1.5", "1.6", in_model), {1, 0, 0}, rounding);
  check_near(axis_of_model("1.6", "1.9", ""), {0, 1, 0}, rounding);
  check_near(axis_of_model("1.9", "1.7", ""), {0, 1, 0}, rounding);
  CHECK_THROWS(axis_of_model("1.4", "1.9", ""), UserError,
               "include.uri = \"part.sdf\": is SDFormat 1.4 and this file 1.9");
  CHECK_THROWS(axis_of_model("1.4", "1.6", ""), UserError, refused);
  CHECK_THROWS(axis_of_model("1.7", "1.4", ""), UserError, refused);
  CHECK_THROWS(axis_of_model("1.6", "1.7", in_model), UserError, refused);
}

/// A joint whose limits leave 0 out starts in their middle, and its link stands there; stops and a spring's rest count
/// from it.
void a_start_in_the_middle_is_counted_from() {
  const std::string text = R"(<sdf version="1.7"><model name="m">
    <link name="a"><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <link name="b"><pose>0 0 2 0 0 0</pose><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>
    <joint name="j" type="KIND"><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz>
      <limit><lower>0.25</lower><upper>1.25</upper></limit>
      <dynamics><spring_stiffness>3</spring_stiffness><spring_reference>0.5</spring_reference></dynamics></axis></joint>
  </model></sdf>)";
  for (const char* const kind : {"prismatic", "revolute"}) {
    std::string of_kind = text;
    of_kind.replace(of_kind.find("KIND"), 4, kind);
    const Scenario scenario = scenario_of(import_robot("m.sdf", read_robot("m.sdf", of_kind), {}), "m.sdf");
    const Joint& made = joint(scenario, "j");  // of a against b
    CHECK_EQUAL(made.stop->low, -0.5);
    CHECK_EQUAL(made.stop->high, 0.5);
    CHECK_EQUAL(made.springs.at(0).rest, 0.25);
    const Body& b = body(scenario, "b");
    const bool slides = std::holds_alternative<SliderJoint>(made.kind);
    check_near(b.position_m, {0, slides ? 0.75 : 0.0, 2}, 1e-15);
    check_near(rotation_vector(b.attitude), {0, slides ? 0.0 : 0.75, 0}, 1e-15);
  }
}

/// Rounding of sums over a few bodies: 3e-14 measured. Of the mistakes below the least shows as 1e-6.
constexpr double rounded = 1e-12;

void a_right_import_is_proved(const char* file, const std::string& text) {
  const Robot robot = read_robot(file, text);
  for (const bool flies : {false, true}) {
    const ImportProof proof = mistaken(file, robot, robot, {.base_free = flies});
    CHECK_EQUAL(proof.states, 20);
    CHECK_BETWEEN(proof.kdl.value_or(1), 0.0, rounded);
#if ODEVAL_WITH_SIMBODY
    CHECK(proof.simbody.has_value());
    CHECK_BETWEEN(*proof.simbody, 0.0, rounded);
#endif
  }
}

/// Each mistake of an importer is seen by KDL, which is given the file's own words.
void a_mistake_of_the_importer_is_caught(const char* file, const std::string& text) {
  const Robot robot = read_robot(file, text);
  const auto caught = [&](const char* what, auto make) {
    Robot wrong = robot;
    make(wrong);
    const ImportProof proof = mistaken(file, robot, wrong);
    if (!proof.kdl || proof.holds() || !(*proof.kdl > 1e-8)) std::printf("not caught: %s in %s\n", what, file);
    CHECK(proof.kdl.has_value());
    CHECK(!proof.holds());
    CHECK(proof.kdl.value_or(0) > 1e-8);
  };
  for (std::size_t i = 1; i < robot.links.size(); ++i) {
    if (robot.links[i].mass && robot.joints[i].kind != Robot::Joint::Kind::free && robot.links[i].name != "plane") {
      caught("a mass", [&](Robot& r) { r.links[i].mass->mass_kg *= 1 + 1e-6; });
      caught("a centre", [&](Robot& r) {
        Vec3& centre = r.links[i].mass->frame.position_m;
        centre = centre + Vec3{1e-5, 1e-5, 1e-5};
      });
      caught("a moment", [&](Robot& r) { r.links[i].mass->inertia_kgm2[0] *= 1.001; });
    }
    if (robot.links[i].mass && robot.links[i].mass->frame.rotation != Frame{}.rotation) {
      caught("an inertia's frame", [&](Robot& r) { r.links[i].mass->frame.rotation = Frame{}.rotation; });
      caught("an inertia's frame the other way",
             [&](Robot& r) { r.links[i].mass->frame.rotation = transposed(r.links[i].mass->frame.rotation); });
    }
    using Kind = Robot::Joint::Kind;
    const Robot::Joint& joint = robot.joints[i];
    if (joint.kind == Kind::hinge || joint.kind == Kind::slider || joint.kind == Kind::universal) {
      caught("an axis's sign", [&](Robot& r) { r.joints[i].axis = -1.0 * r.joints[i].axis; });
    }
    // What hangs on what stands may stand elsewhere and be turned about the vertical: nobody can tell by its motion.
    if (!joint.parent || *joint.parent == 0) continue;
    if (joint.frame.rotation[0] + joint.frame.rotation[4] + joint.frame.rotation[8] < 2.99) {
      caught("a joint's rotation", [&](Robot& r) { r.joints[i].frame.rotation = Frame{}.rotation; });
    }
    if (robot.links[i].mass) {
      caught("a joint's place", [&](Robot& r) { r.joints[i].frame.position_m[0] += 1e-5; });
    }
  }
}

/// What ODE holds is not what the scenario says: seen by both.
void a_mistake_in_ode_is_caught() {
  const Imported imported = import_robot("arm.urdf", read_robot("arm.urdf", arm), {});
  const Scenario scenario = scenario_of(imported, "arm.urdf");
  const Mechanism held = engine_ode::odeval_ode_double().take_back(scenario);
  const auto caught = [&](auto make) {
    Mechanism wrong = held;
    make(wrong);
    const ImportProof proof = catalogue::prove_import(imported, scenario.mechanism, wrong, scenario.gravity);
    CHECK(!proof.holds());
    CHECK(proof.kdl.value_or(0) > 1e-8);
#if ODEVAL_WITH_SIMBODY
    CHECK(proof.simbody.value_or(0) > 1e-8);
#endif
    CHECK_THROWS(catalogue::require_proved(proof, scenario), MachineError, "the import is not proved: at '");
  };
  CHECK(catalogue::prove_import(imported, scenario.mechanism, held, scenario.gravity).holds());
  caught([](Mechanism& m) { m.bodies[1].mass_kg *= 1 + 1e-6; });
  caught([](Mechanism& m) {
    for (const std::size_t element : {1, 3}) (*m.bodies[1].inertia_kgm2)[element] += 1e-5;
  });
  caught([](Mechanism& m) { m.bodies[2].position_m[1] += 1e-5; });
  caught([](Mechanism& m) { m.bodies[1].attitude = Vec3{}; });
  caught([](Mechanism& m) {
    for (Joint& one : m.joints) {
      if (auto* hinge = std::get_if<HingeJoint>(&one.kind)) hinge->axis = -1.0 * hinge->axis;
    }
  });
  caught([](Mechanism& m) {
    for (Joint& one : m.joints) {
      if (auto* hinge = std::get_if<HingeJoint>(&one.kind)) hinge->anchor_m[0] += 1e-5;
    }
  });
}

void turns_of_all_sizes_are_read(double angle) {
  // A fixed base that is turned: the body's attitude, of half a turn and beyond as well.
  Robot robot = read_robot("arm.urdf", arm);
  robot.joints[1].frame.rotation = rotation_about({0.6, 0, 0.8}, angle);
  const Imported imported = import_robot("arm.urdf", robot, {});
  const Scenario scenario = scenario_of(imported, "arm.urdf");
  const Vec3 turn = rotation_vector(body(scenario, "upper").attitude);
  const Vec3 wanted = (angle > half_turn ? angle - 2 * half_turn : angle) * Vec3{0.6, 0, 0.8};
  check_near(turn, wanted, 1e-15 * 8);  // a few roundings of numbers up to 3
}

/// A box from points in each format that is read.
void meshes_are_boxes() {
  const test::TemporaryFolder folder;
  const std::filesystem::path robot = folder.path() / "pkg" / "urdf" / "r.urdf";
  std::filesystem::create_directories(robot.parent_path());
  const auto write = [&](const char* name, const std::string& bytes) {
    std::ofstream(folder.path() / "pkg" / name, std::ios::binary) << bytes;
  };
  write("a.obj", "# points\nv 0 -1 2\nv 4 1 2.5\nf 1 2 1\n");
  write("b.stl", "solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 -1 2\nvertex 4 1 2.5\nvertex 1 1 2\nendloop\n");
  std::string binary(84, '\0');
  binary[80] = 1;
  const std::array<float, 12> numbers{0, 0, 1, 0, -1, 2, 4, 1, 2.5F, 1, 1, 2};
  binary.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers).append(2, '\0');
  write("c.STL", binary);
  write("d.dae", "<COLLADA/>");
  for (const char* mesh : {"../a.obj", "package://pkg/b.stl", "package:///pkg/c.STL", "model://pkg/a.obj"}) {
    const auto box = mesh_box(robot, mesh, "link 'l'");
    CHECK(box.has_value());
    if (!box) continue;
    check_near(box->centre_m, {2, 0, 2.25}, 0);
    check_near(box->sides_m, {4, 2, 0.5}, 0);
  }
  CHECK(!mesh_box(robot, "../d.dae", "link 'l'"));
  CHECK_THROWS(mesh_box(robot, "package://other/a.obj", "link 'l'"), UserError,
               "link 'l': mesh = package://other/a.obj: is not there");
}

/// A link that hangs on nothing, beside one on a hinge: KDL knows it as well.
void a_floating_link_is_proved() {
  const std::string text = R"(<robot name="r"><link name="base"/>
    <link name="a"><inertial><origin xyz="0 0.1 0.2" rpy="0.1 0 0"/><mass value="1"/><inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0.1" iyz="0"/></inertial></link>
    <link name="b"><inertial><origin xyz="0 0.1 0.2" rpy="0.1 0 0"/><mass value="1"/><inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0.1" iyz="0"/></inertial></link>
    <joint name="pin" type="continuous"><parent link="base"/><child link="a"/><origin rpy="0.1 0.2 0.3"/></joint>
    <joint name="off" type="floating"><parent link="a"/><child link="b"/><origin xyz="1 0 0" rpy="0.1 0.2 0.3"/></joint></robot>)";
  const Robot robot = read_robot("r.urdf", text);
  const ImportProof proof = mistaken("r.urdf", robot, robot);
  CHECK_BETWEEN(proof.kdl.value_or(1), 0.0, rounded);
  Robot wrong = robot;
  wrong.links[2].mass->frame.rotation = Frame{}.rotation;
  CHECK(mistaken("r.urdf", robot, wrong).kdl.value_or(0) > 1e-8);
}

/// The states lie beyond the ends of narrow ways, where stops would push: they are no part of the proof, and neither is
/// anything else that acts along joints. So a robot with stops is proved by the same numbers as one without.
void stops_are_no_part_of_the_proof() {
  const Imported imported = import_robot("arm.urdf", read_robot("arm.urdf", arm), {});
  const Scenario scenario = scenario_of(imported, "arm.urdf");
  const auto proved = [&](const std::optional<Stop>& stop) {
    Scenario other = scenario;
    for (Joint& one : other.mechanism.joints) {
      if (one.stop) one.stop = stop;
    }
    return catalogue::prove_import(imported, other);
  };
  const auto stopped =
      std::ranges::count_if(scenario.mechanism.joints, [](const Joint& one) { return one.stop.has_value(); });
  CHECK_EQUAL(stopped, 3);
  const ImportProof narrow = proved(Stop{-1e-3, 1e-3, 0.5});
  const ImportProof none = proved({});
  CHECK(narrow.holds());
  CHECK(narrow.kdl.has_value() && narrow.kdl == none.kdl);
  CHECK(narrow.simbody == none.simbody);
}

void friction_can_be_dropped() {
  const Imported imported = import_robot("arm.urdf", read_robot("arm.urdf", arm), {.drop_friction = true});
  CHECK(!joint(scenario_of(imported, "arm.urdf"), "shoulder").motor);
}

}  // namespace

int main() {
  meshes_are_boxes();
  const bool urdf = reads("URDF");
  const bool sdformat = reads("SDFormat");
  if (!urdf && !sdformat) return 77;
  if (urdf) {
    an_arm_is_what_its_file_says();
    a_right_import_is_proved("arm.urdf", arm);
    a_mistake_of_the_importer_is_caught("arm.urdf", arm);
    a_mistake_in_ode_is_caught();
    a_floating_link_is_proved();
    stops_are_no_part_of_the_proof();
    friction_can_be_dropped();
    for (const double angle : {0.0, 1e-9, 0.1, 1.0, 3.0, 3.14159, 3.2, 6.0}) turns_of_all_sizes_are_read(angle);
  }
  if (sdformat) {
    a_world_is_what_its_file_says();
    frames_are_followed();
    a_model_stands_by_its_placement_frame();
    an_included_model_keeps_its_axes();
    a_start_in_the_middle_is_counted_from();
    a_right_import_is_proved("world.sdf", world);
    a_mistake_of_the_importer_is_caught("world.sdf", world);
  }
  return test::verdict();
}
