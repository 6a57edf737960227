#pragma once
// What random mechanisms are made of: numbers and joints.
#include <cmath>
#include <random>

#include "odeval/mechanism.hpp"

namespace odeval::test {

/// The same numbers with every standard library.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double within(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() - std::mt19937::min()) /
                     static_cast<double>(std::mt19937::max() - std::mt19937::min());
  }
  std::size_t below(std::size_t count) { return engine_() % count; }
  Vec3 vector(double size) { return {within(-size, size), within(-size, size), within(-size, size)}; }
  Vec3 direction() { return unit(vector(1)); }

 private:
  std::mt19937 engine_;
};

inline JointKind any_kind(Random& random, std::size_t kind, const Vec3& anchor) {
  const Vec3 axis = random.direction();
  switch (kind) {
    case 0:
      return HingeJoint{anchor, axis};
    case 1:
      return BallJoint{anchor};
    case 2:
      return SliderJoint{anchor, axis};
    case 3:
      return UniversalJoint{anchor, axis, unit(cross(axis, random.direction()))};
    case 4:
      return FixedJoint{anchor};
    case 5:
      return PistonJoint{anchor, axis};
    case 6:
      return SlidingHingeJoint{anchor, axis, unit(cross(axis, random.direction()))};
    case 7: {
      const Vec3 way = random.direction();
      return SlidingUniversalJoint{anchor, way, axis, unit(cross(axis, random.direction()))};
    }
    default: {
      const double stiffness = random.within(50, 200);
      return Hinge2Joint{anchor, axis, unit(cross(axis, random.direction())), stiffness, random.within(1, 5)};
    }
  }
}

}  // namespace odeval::test
