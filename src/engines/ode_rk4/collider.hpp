#pragma once
// ODE's collision detection at a state.
#include <algorithm>
#include <functional>
#include <optional>
#include <vector>

#include "engines/ode_rk4/accurate_step.hpp"
#include "engines/ode_rk4/impact.hpp"

namespace odeval::engine_rk4 {

class Collider {
 public:
  using Ask = std::function<std::optional<Bounce>(dGeomID, dGeomID)>;

  /// Without a space or an `ask` no geom touches any.
  Collider(dSpaceID space, Ask ask);

  bool works(const Mechanism& mechanism) const {
    const auto stops = [](const Joint& joint) { return !joint.stops.empty(); };
    return (space_ != nullptr && ask_) || std::ranges::any_of(mechanism.joints, stops);
  }

  /// The contacts at a state, with joints at their stops; moves ODE's bodies there. Throws AccurateStepError where a
  /// body is so far away that ODE's hash space would abort, and for a restitution that is none. `ask` is called outside
  /// of ODE's lock and may throw.
  void look(const Mechanism& mechanism, const State& state, std::vector<Contact>& contacts);

  /// Where geoms of the world are and how large: bounds, and of planes what they are. Numbers to compare with others.
  void survey_ground(std::vector<double>& ground) const;

 private:
  void pair_up(dSpaceID space);  // of its geoms and of those in spaces within, into pairs_
  static void near(void* pairs, dGeomID one, dGeomID other);
  void check_reach(const Mechanism& mechanism) const;
  static void stop(const Mechanism& mechanism, const State& state, std::vector<Contact>& contacts);
  void meet(const Mechanism& mechanism, dGeomID one, dGeomID other, std::vector<Contact>& contacts) const;

  dSpaceID space_;
  Ask ask_;
  std::vector<std::pair<dGeomID, dGeomID>> pairs_;
};

}  // namespace odeval::engine_rk4
