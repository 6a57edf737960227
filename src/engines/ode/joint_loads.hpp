#pragma once
// Springs, torques and controllers of joints, and struts: what a program of ODE's adds to its bodies before each step.
#include <ode/ode.h>

#include <array>
#include <optional>
#include <vector>

#include "odeval/mechanism.hpp"
#include "odeval/work.hpp"

namespace odeval::engine_ode {

class JointLoads {
 public:
  /// Of a joint that ODE holds; nothing where nothing acts on it. Of one with several motions one by one, in their
  /// order.
  void add(dJointID made, const Joint& joint);
  /// Of a strut between a body and another, or the world (null).
  void add(dBodyID first, dBodyID second, const Strut& strut);
  bool empty() const { return loads_.empty() && struts_.empty(); }

  /// At the beginning of a step: what controllers that look once a step see, they hold until the next call.
  void sample(double t);
  /// Adds all loads to the bodies as they stand at a time of the step.
  void apply(double t) const;

  /// Of the joints, and motions of joints, that were added and have loads, in that order: what is added at a time, by
  /// kinds.
  Works by_kind(std::size_t load, double t) const;
  /// Likewise: where the joint stands.
  double way_of(std::size_t load) const { return way(loads_[load]); }
  /// Calls with each strut's number, its ends, the direction from the first to the second and the pull of its damper.
  template <class Take>
  void each_strut(const Take& take) const {
    for (std::size_t i = 0; i < struts_.size(); ++i) {
      const Line line = line_of(struts_[i]);
      if (line.long_m > 0) take(i, line.ends, line.along, struts_[i].strut.damping_Ns_m * line.longer_m_s);
    }
  }

 private:
  struct Load {
    dJointID made;
    Joint joint;
    bool turns;                              // else it slides
    std::optional<std::size_t> motion = {};  // of a joint with several
    double start = 0;                        // where that was at t = 0, as ODE tells it
    double near = 0;                         // the way at the last sample: ODE counts angles within half a turn
    double held = 0;
  };
  static void apply(const Load& load, double force);
  static double way(const Load& load);
  static double rate(const Load& load);

  struct Ends {
    dBodyID first;
    dBodyID second;  // null: the world
    Strut strut;
    std::array<Vec3, 2> at;  // in the bodies
  };
  /// The line between the ends as they are; ends that meet have none.
  struct Line {
    std::array<Vec3, 2> ends;
    Vec3 along{};  // unit, from the first to the second
    double long_m = 0;
    double longer_m_s = 0;  // how fast it becomes so
  };
  static Line line_of(const Ends& ends);
  static void apply(const Ends& ends);

  std::vector<Load> loads_;
  std::vector<Ends> struts_;
};

}  // namespace odeval::engine_ode
