#include "engines/mujoco/model_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "engines/tree/principal.hpp"
#include "engines/tree/touching.hpp"
#include "odeval/error.hpp"

namespace odeval::engine_mujoco {
namespace {

using engine_tree::Degree;
using engine_tree::Hanging;

/// NAME="1 2 3", with all the digits that a double has.
template <class Numbers>
std::string attribute(const char* name, const Numbers& numbers) {
  std::string text = std::string(" ") + name + "=\"";
  for (const double number : numbers) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.17g ", number);
    text += digits.data();
  }
  text.back() = '"';
  return text;
}

/// The turn of a body as its parent sees it.
engine_tree::Quaternion against(const engine_tree::Quaternion& parent, const engine_tree::Quaternion& body) {
  const auto [w, x, y, z] = parent;
  const auto [a, b, c, d] = body;
  return {w * a + x * b + y * c + z * d, w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b,
          w * d - x * c + y * b - z * a};
}

/// Of a turn by rows; its trace may be anything.
engine_tree::Quaternion quaternion_of(const Rotation& r) {
  const double trace = r[0] + r[4] + r[8];
  // Four times the squares of w, x, y, z: what is divided by is the largest of them, never less than 1.
  const std::array squares{1 + trace, 1 + 2 * r[0] - trace, 1 + 2 * r[4] - trace, 1 + 2 * r[8] - trace};
  const std::array<engine_tree::Quaternion, 4> rows{{{squares[0], r[7] - r[5], r[2] - r[6], r[3] - r[1]},
                                                     {r[7] - r[5], squares[1], r[1] + r[3], r[2] + r[6]},
                                                     {r[2] - r[6], r[1] + r[3], squares[2], r[5] + r[7]},
                                                     {r[3] - r[1], r[2] + r[6], r[5] + r[7], squares[3]}}};
  const auto largest = static_cast<std::size_t>(std::ranges::max_element(squares) - squares.begin());
  engine_tree::Quaternion found = rows[largest];
  for (double& part : found) part /= 2 * std::sqrt(squares[largest]);
  return found;
}

/// How a constraint takes an error back, as MuJoCo has it by default: critically damped with the time constant T,
/// within the impedances 0.9 and 0.95. What bounces is damped less (in MuJoCo's other format, stiffness and damping),
/// and its impedance is one, so that stiffness and damping are what they say at any depth.
std::string softness(const char* suffix, double restitution, double time_constant_s) {
  constexpr double impedance = 0.95;
  const bool bounces = restitution > 0;
  const double damping = engine_tree::damping_ratio(restitution);
  const double rate = 1 / time_constant_s;
  return attribute(("solref" + std::string(suffix)).c_str(), std::array{-rate * rate, -2 * damping * rate}) +
         attribute(("solimp" + std::string(suffix)).c_str(),
                   std::array{bounces ? impedance : 0.9, impedance, 0.001, 0.5, 2.0});
}

std::string geom_of(std::size_t number) { return "g" + std::to_string(number); }

/// The attributes of a <geom>.
struct Form {
  std::string operator()(const Box& box) const { return " type=\"box\"" + attribute("size", 0.5 * box.sides_m); }
  std::string operator()(const Sphere& ball) const {
    return " type=\"sphere\"" + attribute("size", std::array{ball.diameter_m / 2});
  }
  template <class Bar>
  std::string operator()(const Bar&) const {
    throw UserError("MuJoCo is given boxes and balls to touch, not bars");
  }
  std::string operator()(const HalfSpace& plane) const {
    return " type=\"plane\" size=\"0 0 1\"" + attribute("pos", plane.offset_m * plane.normal) +
           attribute("zaxis", plane.normal);
  }
  std::string operator()(const FixedBox& box) const {
    return (*this)(Box{box.sides_m}) + attribute("pos", box.centre_m);
  }
};

/// The points that a joint holds which closes a loop: two of a hinge's axis; none where bodies are welded.
struct Points {
  std::vector<Vec3> operator()(const BallJoint& ball) const { return {ball.anchor_m}; }
  std::vector<Vec3> operator()(const HingeJoint& hinge) const { return {hinge.anchor_m, hinge.anchor_m + hinge.axis}; }
  std::vector<Vec3> operator()(const FixedJoint&) const { return {}; }
  template <class Other>
  std::vector<Vec3> operator()(const Other&) const {
    throw UserError("MuJoCo closes loops by hinges, ball joints and fixed ones, not by other kinds");
  }
};

class Writer {
 public:
  Writer(const Mechanism& mechanism, const std::vector<Hanging>& tree, double time_constant_s)
      : mechanism_(mechanism), tree_(tree), touching_(mechanism), time_constant_s_(time_constant_s) {}

  std::string obstacles() const {
    std::string text;
    for (std::size_t k = 0; !touching_.empty() && k < mechanism_.obstacles.size(); ++k) {
      text += geom(mechanism_.bodies.size() + k, mechanism_.obstacles[k].shape);
    }
    return text;
  }
  std::string pairs() const {
    std::string text;
    for (std::size_t i = 0; i < mechanism_.bodies.size(); ++i) {
      for (std::size_t j = i + 1; j < touching_.count(); ++j) {
        const Contact* const contact = touching_.between(i, j);
        if (contact == nullptr) continue;
        const double limit = contact->friction ? contact->friction->limit : 0;
        text += "<pair geom1=\"" + geom_of(i) + "\" geom2=\"" + geom_of(j) + "\" margin=\"0\" gap=\"0\" condim=\"" +
                (limit > 0 ? "3" : "1") + "\"" + softness("", contact->restitution, time_constant_s_);
        // Of turning and rolling, which have no part in three dimensions.
        if (limit > 0) text += attribute("friction", std::array{limit, limit, 0.005, 0.0001, 0.0001});
        text += "/>";
      }
    }
    return text.empty() ? "" : "<contact>" + text + "</contact>";
  }
  std::string loops(const std::vector<std::size_t>& closing) const {
    std::string text;
    for (const std::size_t number : closing) {
      const Joint& joint = mechanism_.joints[number];
      if (joint.motor || joint.stop || joint.loaded()) {
        throw UserError("MuJoCo has no motors, stops and loads of a joint that closes a loop");
      }
      const std::string bodies = " body1=\"" + name_of(joint.first) + "\"" +
                                 (joint.second ? " body2=\"" + name_of(*joint.second) + "\"" : "") +
                                 softness("", 0, time_constant_s_);
      const auto points = std::visit(Points{}, joint.kind);
      const auto first = std::ranges::find(tree_, joint.first, &Hanging::body);
      for (const Vec3& point : points) {
        text += "<connect" + bodies + attribute("anchor", first->place.from_centre(point)) + "/>";
      }
      if (points.empty()) text += "<weld" + bodies + "/>";
    }
    return text.empty() ? "" : "<equality>" + text + "</equality>";
  }

  void write(std::optional<std::size_t> parent) {
    for (const Hanging& hanging : tree_) {
      if (hanging.parent == parent) write(hanging);
    }
  }
  std::string take() { return std::move(text_); }

 private:
  template <class Shape>
  static std::string geom(std::size_t number, const Shape& shape) {
    return "<geom name=\"" + geom_of(number) + "\" contype=\"0\" conaffinity=\"0\"" + std::visit(Form{}, shape) + "/>";
  }
  std::string limits(const Hanging& hanging) const {
    const auto& stop = mechanism_.joints[*hanging.joint].stop;
    if (!stop) return "";
    return " limited=\"true\"" + attribute("range", std::array{stop->low, stop->high}) +
           softness("limit", stop->restitution, time_constant_s_);
  }
  void write(const Hanging& hanging) {
    const auto& [parent, place] = std::tie(hanging.parent_place, hanging.place);
    text_ += "<body name=\"" + name_of(hanging.body) + "\"" + attribute("pos", parent.from_centre(place.position_m)) +
             attribute("quat", against(parent.turn, place.turn)) + ">";
    // MuJoCo finds principal axes itself, to seven digits or so.
    const Body& body = mechanism_.bodies[hanging.body];
    const engine_tree::Principal inertia = engine_tree::principal_of(engine_tree::inertia_of(body));
    text_ += "<inertial pos=\"0 0 0\"" + attribute("quat", quaternion_of(inertia.axes)) +
             attribute("mass", std::array{body.mass_kg}) + attribute("diaginertia", inertia.moments_kgm2) + "/>";
    if (!hanging.joint) text_ += "<joint type=\"free\"/>";
    const std::string at = attribute("pos", place.from_centre(hanging.anchor_m));
    if (hanging.ball) text_ += "<joint type=\"ball\"" + at + "/>";
    for (std::size_t k = 0; k < hanging.degrees.size(); ++k) {
      const Degree& degree = hanging.degrees[k];
      text_ += "<joint name=\"" + name_of(hanging.body) + "d" + std::to_string(k) + "\" type=\"" +
               (degree.turns ? "hinge" : "slide") + "\"" + at + attribute("axis", place.in_body(degree.axis)) +
               limits(hanging) + "/>";
    }
    if (!touching_.empty()) text_ += geom(hanging.body, body.shape);
    write(hanging.body);
    text_ += "</body>";
  }

  const Mechanism& mechanism_;
  const std::vector<Hanging>& tree_;
  engine_tree::Touching touching_;
  double time_constant_s_;
  std::string text_;
};

}  // namespace

std::string name_of(std::size_t body) { return "b" + std::to_string(body); }

int equations_of(const JointKind& kind) {
  return std::max<int>(1, static_cast<int>(std::visit(Points{}, kind).size()));
}

// The compiler takes masses and inertias as they are, and angles of joints in radians. The model keeps room for one
// number that is ours, and for eight contacts of each thing.
std::string model_text(const Mechanism& mechanism, const std::vector<Hanging>& tree,
                       const std::vector<std::size_t>& closing, double time_constant_s) {
  Writer writer(mechanism, tree, time_constant_s);
  writer.write(std::nullopt);
  std::string size = "<size nuserdata=\"1\"";
  if (!mechanism.contacts.empty()) {
    const std::size_t contacts = std::max<std::size_t>(100, 8 * mechanism.bodies.size());
    size += " nconmax=\"" + std::to_string(contacts) + "\" njmax=\"" + std::to_string(5 * contacts) + "\"";
  }
  return "<mujoco><compiler angle=\"radian\" boundmass=\"0\" boundinertia=\"0\" balanceinertia=\"false\" "
         "inertiafromgeom=\"false\" fusestatic=\"false\"/>" +
         size +
         "/><default><joint limited=\"false\" stiffness=\"0\" damping=\"0\" armature=\"0\" frictionloss=\"0\"/>"
         "</default><worldbody>" +
         writer.obstacles() + writer.take() + "</worldbody>" + writer.pairs() + writer.loops(closing) + "</mujoco>";
}

}  // namespace odeval::engine_mujoco
