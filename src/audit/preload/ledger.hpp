#pragma once
// What acts on the bodies: works of each kind, and what each joint and each pair of bodies that touch came to at most.
#include <ode/ode.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <unordered_map>
#include <vector>

#include "audit/preload/record_format.hpp"
#include "audit/preload/rows.hpp"
#include "audit/preload/solver_rows.hpp"
#include "audit/preload/worlds.hpp"

namespace odeval::audit {

/// A force on a body changes its energy in a step of ODE by its product with the mean of the body's velocities before
/// and after it, exactly. ODE tells the forces of joints through their feedback, which changes no bit of the step.
class Ledger {
 public:
  explicit Ledger(const std::string& record) : parts_(record + parts_ending), shapes_(record + shapes_ending) {}

  /// While it lives, ODE takes a step of the world.
  class Step {
   public:
    Step(Ledger& ledger, World& world);
    ~Step();
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

    /// The step was taken, of the length h.
    void taken(dReal h);

   private:
    Ledger& ledger_;
    World& world_;
  };

  /// Geoms of bodies that were not seen before, and, before the first step, of what stands in the space.
  void draw(World& world);
  void draw_space(dSpaceID space);

  /// Of the step that was taken.
  void add_work(Head& head) {
    rows_.add_to(head);
    if (std::isfinite(stopping_s_)) head.contact_s = stopping_s_;
  }

  /// Whether some joint, pair or geom had no room.
  bool overflowed() const { return overflowed_; }

 private:
  struct Acting;  // a joint or a contact, in a step
  PartSample* part_of(Joint& joint);
  /// Two bodies that touch: friction of all their contacts in a step, and what it may be, along two axes.
  struct Pair {
    PartSample* part = nullptr;  // null: there was no room
    std::array<double, 2> friction{};
    std::array<double, 2> most{};
    bool touches = false;  // in this step
  };
  Pair& pair_of(std::uint32_t first, std::uint32_t second);
  void take(World& world, Joint& joint, dReal h);
  void take(World& world, Touch& touch, dReal h);
  void sum_up_pairs();
  void draw(dGeomID geom, std::uint32_t body);

  Rows<PartSample> parts_;
  Rows<ShapeSample> shapes_;
  SolverRows rows_;
  std::unordered_map<std::uint64_t, Pair> pairs_;
  std::uint64_t last_key_ = 0;
  Pair* last_pair_ = nullptr;
  std::vector<Pair*> touching_;                                  // in this step
  double stopping_s_ = std::numeric_limits<double>::infinity();  // Head::contact_s
  bool overflowed_ = false;
};

}  // namespace odeval::audit
