#include "model/joint_motions.hpp"

#include <algorithm>

#include "model/joint_kinds.hpp"

namespace odeval {
namespace {

/// On the world a way lies in the child, and is the last.
struct FromParent {
  const JointTable& table;
  const Vec3& centre_m;
  bool on_world = table.parent == world_name;

  using List = std::vector<Elementary>;
  Elementary turn(const Vec3& axis, std::size_t number) const { return {false, axis, table.anchor_m, number}; }
  Elementary way(const Vec3& axis, std::size_t number = 0) const { return {true, axis, table.anchor_m, number}; }
  List way_first(List list) const {
    if (on_world) std::ranges::rotate(list, list.begin() + 1);
    return list;
  }

  List operator()(const BallJoint&) const {
    constexpr std::size_t none = Elementary::in_no_list;
    return {turn({1, 0, 0}, none), turn({0, 1, 0}, none), turn({0, 0, 1}, none)};
  }
  List operator()(const FixedJoint&) const { return {}; }
  List operator()(const HingeJoint&) const { return {turn(table.axis, 0)}; }
  List operator()(const SliderJoint&) const { return {way(table.axis)}; }
  List operator()(const UniversalJoint&) const { return {turn(table.axis, 0), turn(table.axis2, 1)}; }
  List operator()(const Hinge2Joint&) const {
    return {way(table.axis, Elementary::in_no_list), turn(table.axis, 0), turn(table.axis2, 1)};
  }
  List operator()(const PistonJoint&) const { return {way(table.axis), turn(table.axis, 1)}; }
  List operator()(const SlidingHingeJoint&) const { return way_first({way(table.axis), turn(table.axis2, 1)}); }
  List operator()(const SlidingUniversalJoint&) const {
    return way_first({way(table.axis), turn(table.axis2, 1), turn(table.axis3, 2)});
  }
  List operator()(const PlaneJoint&) const {
    return {{true, {1, 0, 0}, centre_m, 0}, {true, {0, 1, 0}, centre_m, 1}, {false, {0, 0, 1}, centre_m, 2}};
  }
};

/// The anchor goes with the second body, or stays in the world.
struct Carry {
  const Frame& first;
  const Frame& second;

  void operator()(BallJoint& joint) const { anchor(joint.anchor_m); }
  void operator()(FixedJoint& joint) const { anchor(joint.anchor_m); }
  void operator()(HingeJoint& joint) const { anchor(joint.anchor_m), turn(second, joint.axis); }
  void operator()(SliderJoint& joint) const { anchor(joint.anchor_m), turn(second, joint.axis); }
  void operator()(PistonJoint& joint) const { anchor(joint.anchor_m), turn(second, joint.axis); }
  void operator()(UniversalJoint& joint) const { crossed(joint); }
  void operator()(Hinge2Joint& joint) const { crossed(joint); }
  void operator()(SlidingHingeJoint& joint) const { crossed(joint); }
  void operator()(SlidingUniversalJoint& joint) const { crossed(joint), turn(first, joint.way); }
  void operator()(PlaneJoint& joint) const { joint.anchor_m = moved(first, joint.anchor_m); }

 private:
  void anchor(Vec3& point) const { point = moved(second, point); }
  static void turn(const Frame& by, Vec3& axis) { axis = turned(by.rotation, axis); }
  template <class Crossed>
  void crossed(Crossed& joint) const {
    anchor(joint.anchor_m), turn(first, joint.axis1), turn(second, joint.axis2);
  }
};

}  // namespace

std::vector<Elementary> motions_of(const JointTable& table, const JointKind& kind, const Vec3& centre_of_child_m) {
  return std::visit(FromParent{table, centre_of_child_m}, kind);
}

JointKind carried(JointKind kind, const Frame& first, const Frame& second) {
  std::visit(Carry{first, second}, kind);
  return kind;
}

}  // namespace odeval
