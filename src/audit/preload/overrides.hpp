#pragma once
// Settings that an audit tries in the place of the program's own.
#include <ode/ode.h>

#include <string>
#include <utility>
#include <vector>

#include "audit/preload/worlds.hpp"

namespace odeval::audit {

class Overrides {
 public:
  using Stepper = int (*)(dWorldID, dReal);

  /// "erp=0.8,stepper=quick", with the keys of environment::tries; others are left alone.
  explicit Overrides(const std::string& text);

  /// Before the first step of a world, of the length h.
  void begin(World& world, dReal h, Stepper stepper) const;
  /// Before each step, since the program may set what it likes in between.
  void apply(World& world) const;
  /// What takes the steps.
  Stepper chosen(Stepper of_program) const;

 private:
  std::vector<std::pair<void (*)(dWorldID, dReal), dReal>> numbers_;  // how each is set, and what to
  Stepper stepper_ = nullptr;                                         // null: the program's
  int finite_rotation_ = -1;                                          // 0, 1; -1: the program's
  bool starts_half_a_step_earlier_ = false;
};

}  // namespace odeval::audit
