#include "engines/mujoco/model_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "engines/tree/principal.hpp"

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

class Writer {
 public:
  Writer(const Mechanism& mechanism, const std::vector<Hanging>& tree) : mechanism_(mechanism), tree_(tree) {}

  void write(std::optional<std::size_t> parent) {
    for (const Hanging& hanging : tree_) {
      if (hanging.parent == parent) write(hanging);
    }
  }
  std::string take() { return std::move(text_); }

 private:
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
               (degree.turns ? "hinge" : "slide") + "\"" + at + attribute("axis", place.in_body(degree.axis)) + "/>";
    }
    write(hanging.body);
    text_ += "</body>";
  }

  const Mechanism& mechanism_;
  const std::vector<Hanging>& tree_;
  std::string text_;
};

}  // namespace

std::string name_of(std::size_t body) { return "b" + std::to_string(body); }

// The compiler takes masses and inertias as they are, and angles of joints in radians. The model keeps room for one
// number that is ours.
std::string model_text(const Mechanism& mechanism, const std::vector<Hanging>& tree) {
  Writer writer(mechanism, tree);
  writer.write(std::nullopt);
  return "<mujoco><compiler angle=\"radian\" boundmass=\"0\" boundinertia=\"0\" balanceinertia=\"false\" "
         "inertiafromgeom=\"false\" fusestatic=\"false\"/><size nuserdata=\"1\"/>"
         "<default><joint limited=\"false\" stiffness=\"0\" damping=\"0\" armature=\"0\" frictionloss=\"0\"/></default>"
         "<worldbody>" +
         writer.take() + "</worldbody></mujoco>";
}

}  // namespace odeval::engine_mujoco
