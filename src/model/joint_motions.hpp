#pragma once
// The motions of a joint as files have them, one after the other from the parent to the child.
#include <vector>

#include "model/description.hpp"
#include "odeval/frame.hpp"

namespace odeval {

/// A velocity of what is rigid: its spin, and how fast the point of it moves that is where the origin is.
struct Twist {
  Vec3 spin{};
  Vec3 origin{};

  friend Twist operator+(const Twist& a, const Twist& b) { return {a.spin + b.spin, a.origin + b.origin}; }
  friend Twist operator*(double s, const Twist& a) { return {s * a.spin, s * a.origin}; }
  friend Twist operator-(const Twist& a, const Twist& b) { return a + -1.0 * b; }
};

/// A point and a velocity of a body that is moved.
inline Vec3 moved(const Frame& by, const Vec3& point) { return by.position_m + turned(by.rotation, point); }
inline Twist moved(const Frame& by, const Twist& twist) {
  const Vec3 spin = turned(by.rotation, twist.spin);
  return {spin, turned(by.rotation, twist.origin) + cross(by.position_m, spin)};
}

/// One motion of a joint as it is drawn: about an axis through a point, or along it.
struct Elementary {
  static constexpr std::size_t in_no_list = 3;

  bool slides = false;
  Vec3 axis{};
  Vec3 at_m{};
  std::size_t number = in_no_list;  // in the file's lists, from 0

  /// How it moves what it carries, by so much.
  Frame by(double q) const {
    if (slides) return {q * axis, Frame{}.rotation};
    const Rotation turn = rotation_about(axis, q);
    return {at_m - turned(turn, at_m), turn};
  }
  /// At a rate of 1, as it is drawn.
  Twist twist() const { return slides ? Twist{{}, axis} : Twist{axis, cross(at_m, axis)}; }
  /// Its rate in a velocity of the child against the parent, as they are drawn: a joint's turns are at right angles to
  /// each other, and so are its ways.
  double rate_in(const Twist& between) const {
    return dot(axis, slides ? between.origin + cross(between.spin, at_m) : between.spin);
  }
};

/// All that a joint leaves, in the order in which one carries the next, the first of them carried by the parent: also
/// what no list of a file has, the turns of a ball and the way of a suspension.
std::vector<Elementary> motions_of(const JointTable& table, const JointKind& kind, const Vec3& centre_of_child_m);

/// A joint's kind with its anchor and axes where its bodies, or the world, have taken them.
JointKind carried(JointKind kind, const Frame& first, const Frame& second);

}  // namespace odeval
