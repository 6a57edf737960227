#include "model/start_pose.hpp"

#include <algorithm>
#include <numeric>

#include "model/rotation_vector.hpp"

namespace odeval {
namespace {

/// One motion of a joint as it is drawn: about an axis through a point, or along it.
struct Elementary {
  bool slides = false;
  Vec3 axis{};
  Vec3 at_m{};
  std::size_t number = 0;  // in the file's lists, from 0
};

/// The motions of a joint, each carried by those before it, the first by the parent. On the world a way lies in the
/// child, and is the last.
struct FromParent {
  const JointTable& table;
  bool on_world;
  const Vec3& centre_m;  // of the child

  using List = std::vector<Elementary>;
  Elementary turn(const Vec3& axis, std::size_t number) const { return {false, axis, table.anchor_m, number}; }
  Elementary way(const Vec3& axis) const { return {true, axis, table.anchor_m, 0}; }

  List operator()(const BallJoint&) const { return {}; }
  List operator()(const FixedJoint&) const { return {}; }
  List operator()(const HingeJoint&) const { return {turn(table.axis, 0)}; }
  List operator()(const SliderJoint&) const { return {way(table.axis)}; }
  List operator()(const UniversalJoint&) const { return {turn(table.axis, 0), turn(table.axis2, 1)}; }
  List operator()(const Hinge2Joint&) const { return {turn(table.axis, 0), turn(table.axis2, 1)}; }
  List operator()(const PistonJoint&) const { return {way(table.axis), turn(table.axis, 1)}; }
  List operator()(const SlidingHingeJoint&) const {
    List list{way(table.axis), turn(table.axis2, 1)};
    if (on_world) std::ranges::rotate(list, list.begin() + 1);
    return list;
  }
  List operator()(const SlidingUniversalJoint&) const {
    List list{way(table.axis), turn(table.axis2, 1), turn(table.axis3, 2)};
    if (on_world) std::ranges::rotate(list, list.begin() + 1);
    return list;
  }
  List operator()(const PlaneJoint&) const {
    return {{true, {1, 0, 0}, centre_m, 0}, {true, {0, 1, 0}, centre_m, 1}, {false, {0, 0, 1}, centre_m, 2}};
  }
};

/// A velocity of what is rigid: its spin, and how fast the point of it moves that is where the origin is.
struct Twist {
  Vec3 spin{};
  Vec3 origin{};

  friend Twist operator+(const Twist& a, const Twist& b) { return {a.spin + b.spin, a.origin + b.origin}; }
  friend Twist operator*(double s, const Twist& a) { return {s * a.spin, s * a.origin}; }
  friend Twist operator-(const Twist& a, const Twist& b) { return a + -1.0 * b; }
};

Twist moved(const Frame& by, const Twist& twist) {
  const Vec3 spin = turned(by.rotation, twist.spin);
  return {spin, turned(by.rotation, twist.origin) + cross(by.position_m, spin)};
}

Vec3 place(const Frame& moved, const Vec3& point) { return moved.position_m + turned(moved.rotation, point); }

Frame by(const Elementary& one, double q) {
  if (one.slides) return {q * one.axis, Frame{}.rotation};
  const Rotation turn = rotation_about(one.axis, q);
  return {one.at_m - turned(turn, one.at_m), turn};
}

/// At a rate of 1, as it is drawn.
Twist twist_of(const Elementary& one) {
  return one.slides ? Twist{{}, one.axis} : Twist{one.axis, cross(one.at_m, one.axis)};
}

/// Of a motion in a relative velocity, as it is drawn: a joint's turns are at right angles to each other, and so are
/// its ways.
double rate_in(const Twist& between, const Elementary& one) {
  return dot(one.axis, one.slides ? between.origin + cross(between.spin, one.at_m) : between.spin);
}

double said_in(const std::vector<double>& list, std::size_t number) { return list.empty() ? 0 : list[number]; }

struct CarryKind {
  const Frame& first;
  const Frame& second;  // where an anchor goes with, also of the world

  void operator()(BallJoint& joint) const { carry(joint.anchor_m); }
  void operator()(FixedJoint& joint) const { carry(joint.anchor_m); }
  void operator()(HingeJoint& joint) const { carry(joint.anchor_m), turn(second, joint.axis); }
  void operator()(SliderJoint& joint) const { carry(joint.anchor_m), turn(second, joint.axis); }
  void operator()(PistonJoint& joint) const { carry(joint.anchor_m), turn(second, joint.axis); }
  void operator()(UniversalJoint& joint) const {
    carry(joint.anchor_m), turn(first, joint.axis1), turn(second, joint.axis2);
  }
  void operator()(Hinge2Joint& joint) const {
    carry(joint.anchor_m), turn(first, joint.axis1), turn(second, joint.axis2);
  }
  void operator()(SlidingHingeJoint& joint) const {
    carry(joint.anchor_m), turn(first, joint.axis1), turn(second, joint.axis2);
  }
  void operator()(SlidingUniversalJoint& joint) const {
    carry(joint.anchor_m), turn(first, joint.way), turn(first, joint.axis1), turn(second, joint.axis2);
  }
  void operator()(PlaneJoint& joint) const { joint.anchor_m = place(first, joint.anchor_m); }

 private:
  void carry(Vec3& anchor) const { anchor = place(second, anchor); }
  static void turn(const Frame& by, Vec3& axis) { axis = turned(by.rotation, axis); }
};

/// What a mechanism is moved by, body by body, from what carries it to what it carries.
class Mover {
 public:
  Mover(Mechanism& mechanism, const std::vector<JointTable>& tables)
      : mechanism_(mechanism), tables_(tables), moved_(mechanism.bodies.size()) {
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      const Body& body = mechanism.bodies[i];
      moved_[i].drawn = {body.spin_rad_s, body.velocity_m_s + cross(body.position_m, body.spin_rad_s)};
      moved_[i].twist = moved_[i].drawn;
    }
  }

  void run() {
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      if (!parent_of(j)) reach(child_of(j), j, true);
    }
    walk();
    // What flies hangs on the first body of it that is no joint's child.
    for (const bool children_too : {false, true}) {
      for (std::size_t i = 0; i < moved_.size(); ++i) {
        if (moved_[i].reached || (!children_too && is_child(i))) continue;
        moved_[i].reached = true;
        queue_.push_back(i);
        walk();
      }
    }
    write();
  }

 private:
  struct Moved {
    Frame by;     // from as it is drawn
    Twist drawn;  // as it is drawn
    Twist twist;  // at the start
    bool reached = false;
    bool touched = false;
  };

  std::size_t child_of(std::size_t joint) const { return mechanism_.joints[joint].carried(); }
  std::optional<std::size_t> parent_of(std::size_t joint) const {
    const Joint& what = mechanism_.joints[joint];
    return what.second ? std::optional(what.first) : std::nullopt;
  }
  bool is_child(std::size_t body) const {
    for (std::size_t j = 0; j < tables_.size(); ++j) {
      if (child_of(j) == body) return true;
    }
    return false;
  }

  void walk() {
    for (; next_ < queue_.size(); ++next_) {
      const std::size_t body = queue_[next_];
      for (std::size_t j = 0; j < tables_.size(); ++j) {
        const std::optional<std::size_t> parent = parent_of(j);
        if (!parent) continue;
        if (*parent == body) reach(child_of(j), j, true);
        if (child_of(j) == body) reach(*parent, j, false);
      }
    }
  }

  /// A body through a joint, of which the other one is where it starts.
  void reach(std::size_t body, std::size_t joint, bool from_parent) {
    Moved& here = moved_[body];
    if (here.reached) return;
    here.reached = true;
    queue_.push_back(body);
    const JointTable& table = tables_[joint];
    const std::optional<std::size_t> parent = parent_of(joint);
    static const Moved world;
    const Moved& other = from_parent ? (parent ? moved_[*parent] : world) : moved_[child_of(joint)];
    here.touched = other.touched || !table.q.empty() || !table.qd.empty();
    if (!here.touched) return;

    const Vec3& centre = mechanism_.bodies[child_of(joint)].position_m;
    const std::vector<Elementary> motions =
        std::visit(FromParent{table, !parent, centre}, mechanism_.joints[joint].kind);
    Frame across;
    for (const Elementary& one : motions) across = across * by(one, said_in(table.q, one.number));
    here.by = from_parent ? other.by * across : other.by * inverse(across);

    Frame at = from_parent ? other.by : here.by;
    const Twist drawn = from_parent ? here.drawn - other.drawn : other.drawn - here.drawn;
    Twist rest = drawn;
    Twist between;
    const Frame parent_by = at;
    for (const Elementary& one : motions) {
      const double rate = rate_in(drawn, one);
      rest = rest - rate * twist_of(one);
      between = between + (rate + said_in(table.qd, one.number)) * moved(at, twist_of(one));
      at = at * by(one, said_in(table.q, one.number));
    }
    between = between + moved(parent_by, rest);
    here.twist = from_parent ? other.twist + between : other.twist - between;
  }

  void write() {
    static const Frame still;
    const auto frame = [&](const std::optional<std::size_t>& body) -> const Frame& {
      return body ? moved_[*body].by : still;
    };
    for (Joint& joint : mechanism_.joints) {
      std::visit(CarryKind{moved_[joint.first].by, frame(joint.second)}, joint.kind);
    }
    for (Strut& strut : mechanism_.struts) {
      strut.first_end_m = place(moved_[strut.first].by, strut.first_end_m);
      strut.second_end_m = place(frame(strut.second), strut.second_end_m);
    }
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      const Moved& to = moved_[i];
      if (!to.touched) continue;
      Body& body = mechanism_.bodies[i];
      body.position_m = place(to.by, body.position_m);
      if (to.by.rotation != Frame{}.rotation) {
        body.attitude = rotation_vector_of(to.by.rotation * rotation_of_vector(rotation_vector(body.attitude)));
      }
      body.spin_rad_s = to.twist.spin;
      body.velocity_m_s = to.twist.origin + cross(to.twist.spin, body.position_m);
    }
  }

  Mechanism& mechanism_;
  const std::vector<JointTable>& tables_;
  std::vector<Moved> moved_;
  std::vector<std::size_t> queue_;
  std::size_t next_ = 0;
};

}  // namespace

bool moves_at_start(const Description& said) {
  return std::ranges::any_of(said.joints,
                             [](const JointTable& joint) { return !joint.q.empty() || !joint.qd.empty(); });
}

std::optional<std::size_t> closes_a_loop(const Description& said) {
  std::vector<std::size_t> leader(said.bodies.size() + 1);
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto leader_of = [&](const std::string& name) {
    std::size_t member = said.body_named(name).value_or(said.bodies.size());
    while (leader[member] != member) member = leader[member];
    return member;
  };
  for (std::size_t j = 0; j < said.joints.size(); ++j) {
    const std::size_t from = leader_of(said.joints[j].parent);
    const std::size_t to = leader_of(said.joints[j].child);
    if (from == to) return j;
    leader[from] = to;
  }
  return std::nullopt;
}

void move_to_start(Mechanism& mechanism, const Description& said) { Mover(mechanism, said.joints).run(); }

}  // namespace odeval
