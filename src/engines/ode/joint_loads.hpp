#pragma once
// Springs, torques and controllers of joints, and struts: what a program of ODE's adds to its bodies before each step.
#include <ode/ode.h>

#include <array>
#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::engine_ode {

class JointLoads {
 public:
  /// Of a hinge or a slider that ODE holds; nothing where nothing acts on it.
  void add(dJointID made, const Joint& joint);
  /// Of a strut between a body and another, or the world (null).
  void add(dBodyID first, dBodyID second, const Strut& strut);
  bool empty() const { return loads_.empty() && struts_.empty(); }

  /// At the beginning of a step: what controllers that look once a step see, they hold until the next call.
  void sample(double t);
  /// Adds all loads to the bodies as they stand at a time of the step.
  void apply(double t) const;

 private:
  struct Load {
    dJointID made;
    Joint joint;
    bool turns;       // a hinge, else a slider
    double near = 0;  // the way at the last sample: ODE counts angles within half a turn
    double held = 0;
  };
  static double way(const Load& load);
  static double rate(const Load& load);

  struct Ends {
    dBodyID first;
    dBodyID second;  // null: the world
    Strut strut;
    std::array<Vec3, 2> at;  // in the bodies
  };
  static void apply(const Ends& ends);

  std::vector<Load> loads_;
  std::vector<Ends> struts_;
};

}  // namespace odeval::engine_ode
