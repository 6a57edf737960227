#include "model/scenario_keys.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>

#include "model/joint_kinds.hpp"
#include "model/limit_text.hpp"
#include "model/problems.hpp"

namespace odeval {

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

std::vector<std::string> problem_names(const Names&) {
  std::vector<std::string> names;
  for (const Problem& problem : problems) names.emplace_back(problem.name);
  return names;
}
std::vector<std::string> shape_names(const Names&) { return {"box", "sphere"}; }
std::vector<std::string> body_shape_names(const Names&) { return {body_shape_words.begin(), body_shape_words.end()}; }
std::vector<std::string> solid_names(const Names&) { return {body_shape_words.begin(), body_shape_words.end() - 1}; }
BodyShape body_shape_named(const std::string& word) {
  return static_cast<BodyShape>(std::ranges::find(body_shape_words, word) - body_shape_words.begin());
}
std::vector<std::string> friction_models(const Names&) { return {"pyramid", "constant"}; }
std::vector<std::string> friction_axes(const Names&) { return {"plane-space", "sliding"}; }
std::vector<std::string> cone_names(const Names&) { return {"pyramidal", "elliptic"}; }
std::vector<std::string> joint_names(const Names&) {
  std::vector<std::string> names;
  for (const JointWord& kind : joint_words) names.emplace_back(kind.word);
  return names;
}
std::vector<std::string> sprung_joint_names(const Names&) {
  std::vector<std::string> names;
  for (const JointWord& kind : joint_words) {
    if (kind.sprung) names.emplace_back(kind.word);
  }
  return names;
}
const JointWord* joint_named(const std::string& word) { return std::ranges::find(joint_words, word, &JointWord::word); }
std::vector<std::string> limit_names(const Names&) { return {"springs", "numbers"}; }
std::vector<std::string> sampling_names(const Names&) { return {"step", "continuous"}; }
std::vector<std::string> start_names(const Names&) { return {"as-given", "half-step"}; }
std::vector<std::string> rotation_names(const Names&) { return {"infinitesimal", "finite"}; }
std::vector<std::string> switch_names(const Names&) { return {"on", "off"}; }
std::vector<std::string> method_names(const Names& names) { return names.methods; }
std::vector<std::string> metric_names(const Names& names) { return names.metrics; }

Spring& spring_of(Scenario& s) { return s.ode.spring ? *s.ode.spring : s.ode.spring.emplace(); }

Softness& softness_of(Description& said) {
  std::optional<Softness>& softness = said.contacts.back().softness;
  return softness ? *softness : softness.emplace();
}
Spring& spring_of(Description& said) {
  std::optional<Spring>& spring = said.contacts.back().spring;
  return spring ? *spring : spring.emplace();
}

Stop& stop_of(Description& said, std::size_t k) {
  std::optional<Stop>& stop = said.joints.back().stops[k];
  return stop ? *stop : stop.emplace();
}
void put_stops(Description& said, std::size_t k, const KeyValue& value) {
  Stop& stop = stop_of(said, k);
  stop.low = value.numbers[0];
  stop.high = value.numbers[1];
}

Vec3 vector(const KeyValue& value) { return {value.numbers[0], value.numbers[1], value.numbers[2]}; }

const Problem* problem_named(const std::string& name) {
  for (const Problem& problem : problems) {
    if (problem.name == name) return &problem;
  }
  return nullptr;
}

using D = Description;
using S = Scenario;
using V = KeyValue;
constexpr auto number = KeyKind::number;
constexpr auto whole = KeyKind::whole;
constexpr auto numbers = KeyKind::numbers;
constexpr auto several = KeyKind::several;
constexpr auto word = KeyKind::word;
constexpr auto words = KeyKind::words;
constexpr auto label = KeyKind::name;
constexpr auto labels = KeyKind::names;

// The ranges are generous, yet keep every quantity ODE forms before its first step a normal number in single precision:
// the least moment of inertia is 1e-6 (1e-4)^2 / 6 = 2e-15 kg m^2, 1/h^2 is at most 1e14. At all their corners ODE
// 0.16.2 sets up without an assert in both precisions; what blows up later is a diverged run, not a bad value.
//
// clang-format off
constexpr KeyRow rows[] = {
  {"", "problem",  word,    "",      0, 0,       false, problem_names, "", "what is simulated",
      [](D& d, S&, const V& v) { d.problem = problem_named(v.word); }},
  {"", "duration", number,  "s",     1e-7, 1e5,  false, nullptr, "", "simulated time",
      [](D&, S& s, const V& v) { s.duration_s = v.number; }},
  {"", "step",     number,  "s",     1e-7, 1,    false, nullptr, "0.001", "step size; without --sample also the spacing of rows",
      [](D&, S& s, const V& v) { s.step_s = v.number; }},
  {"", "sample",   number,  "s",     1e-7, 1e5,  false, nullptr, "every step", "spacing of trace rows, a whole number of steps",
      [](D&, S& s, const V& v) { s.sample_s = v.number; }},
  {"", "gravity",  number,  "m/s²",  0, 1e4,     false, nullptr, "9.81", "downwards",
      [](D&, S& s, const V& v) { s.gravity = v.number; }},
  {"", "n",        whole,   "",      1, 1024,    false, nullptr, "as many as [[links]]", "links of a chain; one table [[links]] then stands for all of them",
      [](D& d, S&, const V& v) { d.n = static_cast<int>(v.number); }},
  {"", "q0",       numbers, "rad",   -1e3, 1e3,  false, nullptr, "none; pendulums need it", "angles at t = 0: q1 from the horizontal, the others relative to the link before; of a chain the first few, the rest are 0",
      [](D& d, S&, const V& v) { d.q0 = v.numbers; }},
  {"", "qd0",      numbers, "rad/s", -1e3, 1e3,  false, nullptr, "none; pendulums need it", "rates at t = 0, likewise",
      [](D& d, S&, const V& v) { d.qd0 = v.numbers; }},
  {"", "rtol",     number,  "",      1e-15, 0.1, false, nullptr, "the method's own", "relative tolerance of adaptive methods",
      [](D&, S& s, const V& v) { s.rtol = v.number; }},
  {"", "atol",     number,  "",      1e-20, 0.1, false, nullptr, "the method's own", "absolute tolerance of adaptive methods",
      [](D&, S& s, const V& v) { s.atol = v.number; }},
  {"", "limit",    word,    "",      0, 0,       false, limit_names, "springs", "what stays of ERP and CFM as the step goes to 0 where ODE's own limit is the reference: the spring and damper that they are, or their numbers",
      [](D& d, S&, const V& v) { d.limit_of_numbers = v.word == "numbers"; }},
  {"", "methods",  words,   "",      0, 0,       false, method_names, "none", "what runs without --method",
      [](D&, S& s, const V& v) { s.methods = v.words; }},

  {"links", "mass",   number, "kg", 1e-6, 1e6, false, nullptr, "", "of the whole link",
      [](D& d, S&, const V& v) { d.links.back().mass_kg = v.number; }},
  {"links", "length", number, "m",  1e-4, 1e3, false, nullptr, "", "from hinge to hinge",
      [](D& d, S&, const V& v) { d.links.back().length_m = v.number; }},
  {"links", "width",  number, "m",  1e-4, 1e3, false, nullptr, "", "across the link, in the plane of swing",
      [](D& d, S&, const V& v) { d.links.back().width_m = v.number; }},
  {"links", "depth",  number, "m",  1e-4, 1e3, false, nullptr, "the width of a ball", "along the hinge",
      [](D& d, S&, const V& v) { d.links.back().depth_m = v.number; }},
  {"links", "shape",  word,   "",   0, 0,      false, shape_names, "box", "a uniform box, or a sphere of diameter width about the far end of a massless rod",
      [](D& d, S&, const V& v) { d.links.back().shape = v.word == "sphere" ? LinkShape::sphere : LinkShape::box; }},

  {"wall", "face",        number, "m", -1e4, 1e4, false, nullptr, "", "x of the wall's face",
      [](D& d, S&, const V& v) { d.wall->face_m = v.number; }},
  {"wall", "restitution", number, "",  0, 1,      false, nullptr, "1", "speed after an impact over speed before",
      [](D& d, S&, const V& v) { d.wall->restitution = v.number; }},

  {"bodies", "shape",    word,    "",      0, 0,       false, body_shape_names, "box; none of a body with [[bodies.shapes]] and no size", "of a uniform solid; a cylinder and a capsule lie along z; none: what [[bodies.shapes]] it has",
      [](D& d, S&, const V& v) { d.bodies.back().shape = body_shape_named(v.word); }},
  {"bodies", "mass",     number,  "kg",    1e-6, 1e6,  false, nullptr, "has to be said, but where [[bodies.shapes]] have all of it", "of the body, without that of its [[bodies.shapes]]",
      [](D& d, S&, const V& v) { d.bodies.back().mass_kg = v.number; }},
  {"bodies", "size",     numbers, "m",     1e-4, 1e3,  false, nullptr, "has to be said, but for shape none", "sides of the box around it, along the body's own axes; of a sphere the diameter, three times",
      [](D& d, S&, const V& v) { d.bodies.back().size_m = vector(v); }, 3},
  {"bodies", "position", numbers, "m",     -1e4, 1e4,  false, nullptr, "0", "of the centre at t = 0, or as drawn where a joint has a q, from where [joint] displaces the first body; this and the next three along the ground where there is one: downhill, across, away",
      [](D& d, S&, const V& v) { d.bodies.back().position_m = vector(v); }, 3},
  {"bodies", "turn",     numbers, "rad",   -1e3, 1e3,  false, nullptr, "0", "rotation vector that turns the world's axes into the body's at t = 0",
      [](D& d, S&, const V& v) { d.bodies.back().turn_rad = vector(v); }, 3},
  {"bodies", "velocity", numbers, "m/s",   -1e4, 1e4,  false, nullptr, "0", "of the centre at t = 0",
      [](D& d, S&, const V& v) { d.bodies.back().velocity_m_s = vector(v); }, 3},
  {"bodies", "spin",     numbers, "rad/s", -1e3, 1e3,  false, nullptr, "0", "about the world's axes at t = 0",
      [](D& d, S&, const V& v) { d.bodies.back().spin_rad_s = vector(v); }, 3},
  {"bodies", "aspect",   number,  "",      1, 1e4,     false, nullptr, "1", "length over thickness: divides the sides x and y of size",
      [](D& d, S&, const V& v) { d.bodies.back().aspect = v.number; }},

  {"bodies", "name",     label,   "",      0, 0,       false, nullptr, "body and its number", "by which [[joints]] know it",
      [](D& d, S&, const V& v) { d.bodies.back().name = v.word; }},
  {"bodies", "centre",   numbers, "m",     -1e3, 1e3,  false, nullptr, "0", "centre of `mass`, from where `position` is, along the body's own axes; it needs an inertia",
      [](D& d, S&, const V& v) { d.bodies.back().centre_m = vector(v); }, 3},
  {"bodies", "inertia",  numbers, "kg m²", -1e9, 1e9,  false, nullptr, "that of a uniform solid", "xx, yy, zz, xy, xz, yz of the tensor about the centre of `mass`, along the body's own axes",
      [](D& d, S&, const V& v) { std::ranges::copy(v.numbers, d.bodies.back().inertia_kgm2.emplace().begin()); }, 6},

  {"bodies.shapes", "shape",    word,    "",      0, 0,       false, solid_names, "box", "as of [[bodies]]",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().shape = body_shape_named(v.word); }},
  {"bodies.shapes", "size",     numbers, "m",     1e-4, 1e3,  false, nullptr, "", "as of [[bodies]], along its own axes",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().size_m = vector(v); }, 3},
  {"bodies.shapes", "mass",     number,  "kg",    0, 1e6,     false, nullptr, "0", "that it adds to the body's, as a uniform solid",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().mass_kg = v.number; }},
  {"bodies.shapes", "position", numbers, "m",     -1e3, 1e3,  false, nullptr, "0", "of its centre, from where the body's `position` is, along the body's own axes",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().position_m = vector(v); }, 3},
  {"bodies.shapes", "turn",     numbers, "rad",   -1e3, 1e3,  false, nullptr, "0", "rotation vector that turns the body's own axes into those of the shape; not of a sphere",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().turn_rad = vector(v); }, 3},
  {"bodies.shapes", "name",     label,   "",      0, 0,       false, nullptr, "none", "by which [[contacts]] know it, behind its body's: body.shape",
      [](D& d, S&, const V& v) { d.bodies.back().shapes.back().name = v.word; }},

  {"joints", "kind",     word,    "",      0, 0,       false, joint_names, "", "what it holds, and what it leaves free",
      [](D& d, S&, const V& v) { d.joints.back().kind = joint_named(v.word); }},
  {"joints", "parent",   label,   "",      0, 0,       false, nullptr, "", "name of the body that carries, or world",
      [](D& d, S&, const V& v) { d.joints.back().parent = v.word; }},
  {"joints", "child",    label,   "",      0, 0,       false, nullptr, "", "name of the body that is carried",
      [](D& d, S&, const V& v) { d.joints.back().child = v.word; }},
  {"joints", "anchor",   numbers, "m",     -1e4, 1e4,  false, nullptr, "0", "where the joint is as it is drawn",
      [](D& d, S&, const V& v) { d.joints.back().anchor_m = vector(v); }, 3},
  {"joints", "axis",     numbers, "",      -1e3, 1e3,  false, nullptr, "[0, 1, 0]", "of a hinge, a slider, a piston or, fixed in the parent, a universal joint; of pr, pu and hinge2 the way; in the world as it is drawn",
      [](D& d, S&, const V& v) { d.joints.back().axis = vector(v); }, 3},
  {"joints", "axis2",    numbers, "",      -1e3, 1e3,  false, nullptr, "[1, 0, 0]", "of a universal joint or a hinge2, fixed in the child, at right angles to the other; of pr the turn; of pu the turn in the parent; likewise",
      [](D& d, S&, const V& v) { d.joints.back().axis2 = vector(v); }, 3},
  {"joints", "axis3",    numbers, "",      -1e3, 1e3,  false, nullptr, "[0, 0, 1]", "of pu the turn in the child, at right angles to axis2; likewise",
      [](D& d, S&, const V& v) { d.joints.back().axis3 = vector(v); }, 3},
  {"joints", "suspension", numbers, "N/m, N s/m", 0, 1e9, false, nullptr, "none; hinge2 needs it", "spring and damper of a hinge2 along its way, relaxed at t = 0",
      [](D& d, S&, const V& v) { std::ranges::copy(v.numbers, d.joints.back().suspension.begin()); }, 2},

  {"joints", "name",     label,   "",      0, 0,       false, nullptr, "joint and its number", "by which [[springs]], [[torques]] and [[controllers]] know it",
      [](D& d, S&, const V& v) { d.joints.back().name = v.word; }},
  {"joints", "q",        several, "rad or m", -1e4, 1e4, false, nullptr, "0", "where it starts, the child against the parent, from as it is drawn: it moves the child and all that hangs on it; of a joint with several motions all of them, in the order of their motors",
      [](D& d, S&, const V& v) { d.joints.back().q = v.numbers; }},
  {"joints", "qd",       several, "rad/s or m/s", -1e3, 1e3, false, nullptr, "0", "likewise its rate, which is added to what the bodies' velocities say",
      [](D& d, S&, const V& v) { d.joints.back().qd = v.numbers; }},
  {"joints", "stops",    numbers, "rad or m", -1e4, 1e4, false, nullptr, "none", "ends of the way of a hinge or a slider, the child against the parent, from as it is drawn, or of the motion of a joint with several that `motor` drives; those of a turn within half a turn",
      [](D& d, S&, const V& v) { put_stops(d, 0, v); }, 2},
  {"joints", "stop_restitution", number, "", 0, 1,     false, nullptr, "0", "speed after striking a stop over speed before",
      [](D& d, S&, const V& v) { stop_of(d, 0).restitution = v.number; }},
  {"joints", "stops2",   numbers, "rad", -1e4, 1e4, false, nullptr, "none", "likewise of the motion that `motor2` drives; hinge2 has none there",
      [](D& d, S&, const V& v) { put_stops(d, 1, v); }, 2},
  {"joints", "stop_restitution2", number, "", 0, 1,    false, nullptr, "0", "likewise, of stops2",
      [](D& d, S&, const V& v) { stop_of(d, 1).restitution = v.number; }},
  {"joints", "stops3",   numbers, "rad", -1e4, 1e4, false, nullptr, "none", "likewise of the motion that `motor3` drives",
      [](D& d, S&, const V& v) { put_stops(d, 2, v); }, 2},
  {"joints", "stop_restitution3", number, "", 0, 1,    false, nullptr, "0", "likewise, of stops3",
      [](D& d, S&, const V& v) { stop_of(d, 2).restitution = v.number; }},
  {"joints.motor", "velocity", number, "rad/s or m/s", -1e3, 1e3, false, nullptr, "", "that it keeps, the child against the parent; of a joint with several axes about or along `axis`, of a piston along it, of plane2d along the world's x",
      [](D& d, S&, const V& v) { d.joints.back().motors[0]->speed = v.number; }},
  {"joints.motor", "force", number, "N m or N", 0, 1e9, false, nullptr, "", "that it has at most",
      [](D& d, S&, const V& v) { d.joints.back().motors[0]->most = v.number; }},
  {"joints.motor2", "velocity", number, "rad/s or m/s", -1e3, 1e3, false, nullptr, "", "likewise, about `axis2`, of a piston about `axis`, of plane2d along y",
      [](D& d, S&, const V& v) { d.joints.back().motors[1]->speed = v.number; }},
  {"joints.motor2", "force", number, "N m or N", 0, 1e9, false, nullptr, "", "that it has at most",
      [](D& d, S&, const V& v) { d.joints.back().motors[1]->most = v.number; }},
  {"joints.motor3", "velocity", number, "rad/s", -1e3, 1e3, false, nullptr, "", "likewise, about `axis3`, of plane2d about z",
      [](D& d, S&, const V& v) { d.joints.back().motors[2]->speed = v.number; }},
  {"joints.motor3", "force", number, "N m", 0, 1e9, false, nullptr, "", "that it has at most",
      [](D& d, S&, const V& v) { d.joints.back().motors[2]->most = v.number; }},

  {"springs", "joint",     label,  "",                 0, 0,      false, nullptr, "", "name of a joint",
      [](D& d, S&, const V& v) { d.springs.back().joint = v.word; }},
  {"springs", "motion", whole, "", 1, 3, false, nullptr, "of a joint with several to be said", "of a joint with several motions the one that it acts on, by the number of its motor",
      [](D& d, S&, const V& v) { d.springs.back().motion = static_cast<std::size_t>(v.number); }},
  {"springs", "stiffness", number, "N m/rad or N/m",     0, 1e12,   false, nullptr, "0", "of the spring",
      [](D& d, S&, const V& v) { d.springs.back().load.stiffness = v.number; }},
  {"springs", "damping",   number, "N m s/rad or N s/m", 0, 1e12,   false, nullptr, "0", "of the damper beside it",
      [](D& d, S&, const V& v) { d.springs.back().load.damping = v.number; }},
  {"springs", "rest",      number, "rad or m",           -1e4, 1e4, false, nullptr, "0", "way at which it is relaxed, counted as stops are",
      [](D& d, S&, const V& v) { d.springs.back().load.rest = v.number; }},

  {"torques", "joint",     label,   "",         0, 0,      false, nullptr, "", "name of a joint; along a way it is a force",
      [](D& d, S&, const V& v) { d.torques.back().joint = v.word; }},
  {"torques", "motion", whole, "", 1, 3, false, nullptr, "of a joint with several to be said", "of a joint with several motions the one that it acts on, by the number of its motor",
      [](D& d, S&, const V& v) { d.torques.back().motion = static_cast<std::size_t>(v.number); }},
  {"torques", "constant",  number,  "N m or N", -1e9, 1e9, false, nullptr, "0", "on the child, against the parent",
      [](D& d, S&, const V& v) { d.torques.back().load.constant = v.number; }},
  {"torques", "amplitude", number,  "N m or N", -1e9, 1e9, false, nullptr, "0", "of a sine on top of it",
      [](D& d, S&, const V& v) { d.torques.back().load.amplitude = v.number; }},
  {"torques", "frequency", number,  "Hz",       0, 1e6,    false, nullptr, "0", "of the sine",
      [](D& d, S&, const V& v) { d.torques.back().load.frequency_Hz = v.number; }},
  {"torques", "phase",     number,  "rad",      -1e3, 1e3, false, nullptr, "0", "of the sine at t = 0",
      [](D& d, S&, const V& v) { d.torques.back().load.phase_rad = v.number; }},
  {"torques", "times",     numbers, "s",        -1e5, 1e5, false, nullptr, "none", "of a table on top of both, rising",
      [](D& d, S&, const V& v) { d.torques.back().load.times_s = v.numbers; }},
  {"torques", "values",    numbers, "N m or N", -1e9, 1e9, false, nullptr, "none", "at these times; straight lines between them, the first and the last beyond",
      [](D& d, S&, const V& v) { d.torques.back().load.values = v.numbers; }},

  {"controllers", "joint",    label,   "",                 0, 0,      false, nullptr, "", "name of a joint",
      [](D& d, S&, const V& v) { d.controllers.back().joint = v.word; }},
  {"controllers", "motion", whole, "", 1, 3, false, nullptr, "of a joint with several to be said", "of a joint with several motions the one that it acts on, by the number of its motor",
      [](D& d, S&, const V& v) { d.controllers.back().motion = static_cast<std::size_t>(v.number); }},
  {"controllers", "kp",       number,  "N m/rad or N/m",     0, 1e12,   false, nullptr, "", "load over distance from the target",
      [](D& d, S&, const V& v) { d.controllers.back().load.kp = v.number; }},
  {"controllers", "kd",       number,  "N m s/rad or N s/m", 0, 1e12,   false, nullptr, "0", "load against the rate, over it",
      [](D& d, S&, const V& v) { d.controllers.back().load.kd = v.number; }},
  {"controllers", "sampling", word,    "",                 0, 0,      false, sampling_names, "step", "whether it looks once a step, and holds its load until the next, or at every moment",
      [](D& d, S&, const V& v) { d.controllers.back().load.sampled = v.word == "step"; }},
  {"controllers", "target",   number,  "rad or m",           -1e4, 1e4, false, nullptr, "0", "way to keep, counted as stops are",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.constant = v.number; }},
  {"controllers", "amplitude", number, "rad or m",           -1e4, 1e4, false, nullptr, "0", "of a sine on top of it",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.amplitude = v.number; }},
  {"controllers", "frequency", number, "Hz",                 0, 1e6,    false, nullptr, "0", "of the sine",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.frequency_Hz = v.number; }},
  {"controllers", "phase",    number,  "rad",                -1e3, 1e3, false, nullptr, "0", "of the sine at t = 0",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.phase_rad = v.number; }},
  {"controllers", "times",    numbers, "s",                  -1e5, 1e5, false, nullptr, "none", "of a table on top of both, rising",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.times_s = v.numbers; }},
  {"controllers", "values",   numbers, "rad or m",           -1e4, 1e4, false, nullptr, "none", "at these times; straight lines between them, the first and the last beyond",
      [](D& d, S&, const V& v) { d.controllers.back().load.target.values = v.numbers; }},

  {"planes", "name",     label,   "",  0, 0,      false, nullptr, "", "by which [[contacts]] know it",
      [](D& d, S&, const V& v) { d.planes.back().name = v.word; }},
  {"planes", "normal",   numbers, "",  -1e3, 1e3, false, nullptr, "[0, 0, 1]", "away from what is solid",
      [](D& d, S&, const V& v) { d.planes.back().normal = vector(v); }, 3},
  {"planes", "point",    numbers, "m", -1e4, 1e4, false, nullptr, "0", "of the plane",
      [](D& d, S&, const V& v) { d.planes.back().point_m = vector(v); }, 3},

  {"contacts", "between",     labels, "",  0, 0,   false, nullptr, "all that no joint connects", "names of two that touch: bodies, planes, or shapes of a body as body.shape",
      [](D& d, S&, const V& v) { d.contacts.back().between = v.words; }, 2},
  {"contacts", "restitution", number, "",  0, 1,   false, nullptr, "0", "speed after an impact over speed before",
      [](D& d, S&, const V& v) { d.contacts.back().restitution = v.number; }},
  {"contacts", "friction",    number, "",  0, 1e9, false, nullptr, "none", "coefficient of friction",
      [](D& d, S&, const V& v) { d.contacts.back().friction = v.number; }},
  {"contacts", "erp",         number, "",  0, 1,   false, nullptr, "that of ode", "error reduction parameter of these contacts, with cfm",
      [](D& d, S&, const V& v) { softness_of(d).erp = v.number; }},
  {"contacts", "cfm",         number, "",  0, 1e3, false, nullptr, "that of ode", "constraint force mixing of these contacts, with erp",
      [](D& d, S&, const V& v) { softness_of(d).cfm = v.number; }},
  {"contacts", "kp",          number, "N/m",   0, 1e12, false, nullptr, "none", "spring of each point that touches, with kd",
      [](D& d, S&, const V& v) { spring_of(d).kp_N_m = v.number; }},
  {"contacts", "kd",          number, "N s/m", 0, 1e12, false, nullptr, "none", "damper of each point that touches, with kp",
      [](D& d, S&, const V& v) { spring_of(d).kd_Ns_m = v.number; }},
  {"struts", "parent",    label,   "",      0, 0,      false, nullptr, "", "name of a body, or world",
      [](D& d, S&, const V& v) { d.struts.back().parent = v.word; }},
  {"struts", "child",     label,   "",      0, 0,      false, nullptr, "", "name of the body at the other end",
      [](D& d, S&, const V& v) { d.struts.back().child = v.word; }},
  {"struts", "from",      numbers, "m",     -1e4, 1e4, false, nullptr, "", "end in the parent, in the world as it is drawn",
      [](D& d, S&, const V& v) { d.struts.back().from_m = vector(v); }, 3},
  {"struts", "to",        numbers, "m",     -1e4, 1e4, false, nullptr, "", "end in the child, likewise",
      [](D& d, S&, const V& v) { d.struts.back().to_m = vector(v); }, 3},
  {"struts", "stiffness", number,  "N/m",   0, 1e12,   false, nullptr, "0", "of the spring between the ends",
      [](D& d, S&, const V& v) { d.struts.back().stiffness = v.number; }},
  {"struts", "damping",   number,  "N s/m", 0, 1e12,   false, nullptr, "0", "of the damper beside it",
      [](D& d, S&, const V& v) { d.struts.back().damping = v.number; }},
  {"struts", "rest",      number,  "m",     0, 1e4,    false, nullptr, "as long as it is drawn", "length at which it is relaxed",
      [](D& d, S&, const V& v) { d.struts.back().rest_m = v.number; }},

  {"ground", "slope",       number, "rad", -1.5, 1.5, false, nullptr, "0", "how steeply the ground falls towards +x",
      [](D& d, S&, const V& v) { d.ground->slope_rad = v.number; }},
  {"ground", "restitution", number, "",    0, 1,      false, nullptr, "0", "speed after an impact over speed before",
      [](D& d, S&, const V& v) { d.ground->restitution = v.number; }},
  {"ground", "friction",    number, "",    0, 1e9,    false, nullptr, "0", "coefficient of friction, or the force in N that the constant model allows a body",
      [](D& d, S&, const V& v) { d.ground->friction = v.number; }},
  {"ground", "friction_model", word, "",   0, 0,      false, friction_models, "pyramid", "what bounds friction: the normal force, or a constant",
      [](D& d, S&, const V& v) { d.ground->friction_model = v.word == "constant" ? FrictionModel::constant : FrictionModel::pyramid; }},

  {"joint", "kind",         word,    "",  0, 0,      false, sprung_joint_names, "", "of the first body to the world, or to the second where there are two",
      [](D& d, S&, const V& v) { d.joint->kind = joint_named(v.word); }},
  {"joint", "anchor",       numbers, "m", -1e4, 1e4, false, nullptr, "0", "where the joint is when it is closed",
      [](D& d, S&, const V& v) { d.joint->anchor_m = vector(v); }, 3},
  {"joint", "axis",         numbers, "",  -1e3, 1e3, false, nullptr, "[0, 1, 0]", "of a hinge",
      [](D& d, S&, const V& v) { d.joint->axis = vector(v); }, 3},
  {"joint", "displacement", numbers, "m", -1e3, 1e3, false, nullptr, "0", "how far the first body stands away from its place at t = 0",
      [](D& d, S&, const V& v) { d.joint->displacement_m = vector(v); }, 3},

  {"ode", "erp",                number, "",       0, 1,          false, nullptr, "0.2", "error reduction parameter",
      [](D&, S& s, const V& v) { s.ode.erp = v.number; }},
  {"ode", "cfm",                number, "",       0, 1e3,        false, nullptr, "1e-5", "constraint force mixing",
      [](D&, S& s, const V& v) { s.ode.cfm = v.number; }},
  {"ode", "kp",                 number, "N/m",    0, 1e12,       false, nullptr, "erp and cfm", "spring of the joints; with kd in the place of erp and cfm",
      [](D&, S& s, const V& v) { spring_of(s).kp_N_m = v.number; }},
  {"ode", "kd",                 number, "N s/m",  0, 1e12,       false, nullptr, "erp and cfm", "damper of the joints; with kp in the place of erp and cfm",
      [](D&, S& s, const V& v) { spring_of(s).kd_Ns_m = v.number; }},
  {"ode", "iterations",         whole,  "",       1, 100000,     false, nullptr, "20", "of QuickStep",
      [](D&, S& s, const V& v) { s.ode.iterations = static_cast<int>(v.number); }},
  {"ode", "sor_w",              number, "",       0, 2,          true,  nullptr, "1.3", "over-relaxation of QuickStep",
      [](D&, S& s, const V& v) { s.ode.sor_w = v.number; }},
  {"ode", "bounce",             number, "",       0, 1,          false, nullptr, "that of wall or ground", "restitution of contacts in ODE; the reference keeps that of wall or ground",
      [](D&, S& s, const V& v) { s.ode.bounce = v.number; }},
  {"ode", "bounce_vel",         number, "m/s",    0, 1e6,        false, nullptr, "0", "slower contacts do not bounce",
      [](D&, S& s, const V& v) { s.ode.bounce_vel = v.number; }},
  {"ode", "max_correcting_vel", number, "m/s",    0, inf,        false, nullptr, "inf", "limit on the speed that mends an overlap",
      [](D&, S& s, const V& v) { s.ode.max_correcting_vel = v.number; }},
  {"ode", "surface_layer",      number, "m",      0, 1e3,        false, nullptr, "0", "overlap of contacts that is left alone",
      [](D&, S& s, const V& v) { s.ode.surface_layer = v.number; }},
  {"ode", "friction_axes",      word,   "",       0, 0,          false, friction_axes, "plane-space", "along what friction acts: ODE's own axes of the plane, or the way a contact slides",
      [](D&, S& s, const V& v) { s.ode.friction_axes = v.word == "sliding" ? FrictionAxes::sliding : FrictionAxes::plane_space; }},
  {"ode", "start",              word,   "",       0, 0,          false, start_names, "as-given", "velocities at t = 0 as given, or those of half a step before",
      [](D&, S& s, const V& v) { s.ode.start = v.word == "half-step" ? Start::half_step : Start::as_given; }},
  {"ode", "seed",               whole,  "",       0, 4294967295, false, nullptr, "0", "of ODE's random numbers (QuickStep)",
      [](D&, S& s, const V& v) { s.ode.seed = static_cast<std::uint32_t>(v.number); }},
  {"ode", "gyroscopic",         word,   "",       0, 0,          false, switch_names, "on", "the torque -w x (I w) that makes a body tumble",
      [](D&, S& s, const V& v) { s.ode.gyroscopic = v.word == "on"; }},
  {"ode", "rotation",           word,   "",       0, 0,          false, rotation_names, "infinitesimal", "how a step turns a body: along the tangent, or by the whole angle (dBodySetFiniteRotationMode)",
      [](D&, S& s, const V& v) { s.ode.rotation = v.word == "finite" ? Turning::finite : Turning::infinitesimal; }},

  {"bullet", "iterations", whole, "", 1, 1e6, false, nullptr, "10", "Bullet's iterations over joints and contacts",
      [](D&, S& s, const V& v) { s.bullet.iterations = static_cast<int>(v.number); }},
  {"bullet", "erp", number, "", 0, 1, false, nullptr, "0.2", "part of a joint's or a contact's error that Bullet takes back in a step",
      [](D&, S& s, const V& v) { s.bullet.erp = v.number; }},

  {"mujoco", "time_constant", number, "s", 0, 1e3, true, nullptr, "0.02", "within which contacts, stops and loops of MuJoCo take an error back (solref)",
      [](D&, S& s, const V& v) { s.mujoco.time_constant_s = v.number; }},
  {"mujoco", "cone", word, "", 0, 0, false, cone_names, "pyramidal", "what bounds MuJoCo's friction",
      [](D&, S& s, const V& v) { s.mujoco.elliptic = v.word == "elliptic"; }},

  {"maximal", "ks", number, "1/s²", 0, 1e14, false, nullptr, "400", "feedback of a joint's position error",
      [](D&, S& s, const V& v) { s.maximal.ks = v.number; }},
  {"maximal", "kd", number, "1/s",  0, 1e8,  false, nullptr, "40", "feedback of a joint's velocity error",
      [](D&, S& s, const V& v) { s.maximal.kd = v.number; }},

  {"tolerances", "method",   word,   "",  0, 0,       false, method_names, "", "whose metric",
      [](D&, S& s, const V& v) { s.tolerances.back().method = v.word; }},
  {"tolerances", "metric",   word,   "",  0, 0,       false, metric_names, "", "which metric is limited",
      [](D&, S& s, const V& v) { s.tolerances.back().metric = v.word; }},
  {"tolerances", "until",    number, "s", 1e-7, 1e5,  false, nullptr, "", "the metric's last sample",
      [](D&, S& s, const V& v) { s.tolerances.back().until_s = v.number; }},
  {"tolerances", "at_most",  number, "",  -1e300, 1e300, false, nullptr, "no greatest value", "greatest value allowed, in the metric's unit",
      [](D&, S& s, const V& v) { s.tolerances.back().at_most = v.number; }},
  {"tolerances", "at_least", number, "",  -1e300, 1e300, false, nullptr, "no least value", "least value allowed, in the metric's unit",
      [](D&, S& s, const V& v) { s.tolerances.back().at_least = v.number; }},
};
// clang-format on

constexpr SectionRow sections[] = {{"links", true},          {"wall", false},          {"bodies", true},
                                   {"bodies.shapes", true},  {"joints", true},         {"joints.motor", false},
                                   {"joints.motor2", false}, {"joints.motor3", false}, {"springs", true},
                                   {"torques", true},        {"controllers", true},    {"struts", true},
                                   {"planes", true},         {"contacts", true},       {"ground", false},
                                   {"joint", false},         {"ode", false},           {"bullet", false},
                                   {"mujoco", false},        {"maximal", false},       {"tolerances", true}};

}  // namespace

std::span<const KeyRow> key_table() { return rows; }
std::span<const SectionRow> section_table() { return sections; }
std::vector<std::string> section_names() {
  std::vector<std::string> names;
  for (const SectionRow& section : sections) {
    if (!section.inner()) names.emplace_back(section.name);
  }
  return names;
}

const KeyRow* find_key(std::string_view section, std::string_view name) {
  for (const KeyRow& row : key_table()) {
    if (row.section == section && row.name == name) return &row;
  }
  return nullptr;
}

std::string rule_of(const KeyRow& row, const Names& names) {
  const std::string range =
      row.ends_excluded
          ? fmt::format("between {} and {}, ends excluded", limit_text(row.least), limit_text(row.greatest))
          : fmt::format("from {} to {}", limit_text(row.least), limit_text(row.greatest));
  const std::string unit = row.unit.empty() ? "" : fmt::format(" {}", row.unit);
  switch (row.kind) {
    case KeyKind::number:
      return fmt::format("must be a number {}{}", range, unit);
    case KeyKind::whole:
      return fmt::format("must be a whole number {}{}", range, unit);
    case KeyKind::numbers:
      return fmt::format("must be a list of {}numbers {}{}", row.count == 0 ? "" : fmt::format("{} ", row.count), range,
                         unit);
    case KeyKind::several:
      return fmt::format("must be a number or a list of numbers {}{}", range, unit);
    case KeyKind::names:
      return fmt::format("must be a list of {} names", row.count);
    case KeyKind::name:
      return "must be a name of at most 40 letters, digits, '_' and '-'";
    case KeyKind::word:
    case KeyKind::words:
      break;
  }
  return fmt::format("must be {} {}", row.kind == KeyKind::word ? "one of" : "a list of",
                     fmt::join(row.allowed(names), ", "));
}

}  // namespace odeval
