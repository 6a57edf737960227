#pragma once
// Springs, torques and controllers of joints: what a program of ODE's adds to its bodies before each step.
#include <ode/ode.h>

#include <vector>

#include "odeval/mechanism.hpp"

namespace odeval::engine_ode {

class JointLoads {
 public:
  /// Of a hinge or a slider that ODE holds; nothing where nothing acts on it.
  void add(dJointID made, const Joint& joint);
  bool empty() const { return loads_.empty(); }

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

  std::vector<Load> loads_;
};

}  // namespace odeval::engine_ode
