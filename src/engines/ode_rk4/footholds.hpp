#pragma once
// What stands on something and sticks there: a corner on a plane is held as by a ball joint, an edge as by a hinge, a
// face as by a fixed joint, and so moves to the order of the Runge-Kutta formula. Friction and weight bear that as long
// as some forces at the contacts, that push and keep to their cones, do what the joint does. A joint that lies against
// its stop is held there in the same way, as long as the stop pushes.
#include <optional>
#include <span>
#include <vector>

#include "engines/ode_rk4/impact.hpp"
#include "engines/ode_rk4/motion.hpp"

namespace odeval::engine_rk4 {

/// Does one of its geoms roll? Of a stop, no.
bool is_round(const Contact& contact);
/// Of a ball and what is convex: they meet at one point at most.
bool is_only_one(const Contact& contact);

class Footholds {
 public:
  /// Of contacts that rest at a state, of flat geoms that do not slip. Nothing where none can be held: what is joined
  /// to, or touches, something that does not stick is left as it is, and so are closed loops that say the same twice.
  /// Faces that have been struck just now lie down first: not all of their corners touch to rounding.
  static std::optional<Footholds> of(const Mechanism& mechanism, const AccurateStepOptions& options,
                                     std::span<const Contact> contacts, const State& state, bool struck);

  /// Is it one that can be held at all: of flat geoms that rub, of a ball that rolls, of a stop?
  static bool can_hold(const Mechanism& mechanism, const Contact& contact);

  /// Of the mechanism with these joints, which come last.
  Motion& motion() { return motion_; }
  const Motion& motion() const { return motion_; }
  bool have(const Contact& contact) const;
  /// Is it one that corners or edges stand on, or of a face? `state`: where it was found.
  bool stand_on(const Contact& contact, const State& state) const;
  /// Does a state keep them, and rest on them?
  bool fit(const State& state) const;
  /// Do contacts, those of the state at hand, do what the joints do there, `t` into a step?
  bool bear(const State& state, Forces& forces, double t, std::span<const Contact> contacts);

 private:
  struct Foothold {
    std::pair<const void*, const void*> geoms;
    std::size_t joint;
  };
  Footholds(Mechanism mechanism, int order, std::vector<Foothold> footholds)
      : motion_(std::move(mechanism), order), footholds_(std::move(footholds)) {}

  Motion motion_;
  std::vector<Foothold> footholds_;
};

}  // namespace odeval::engine_rk4
