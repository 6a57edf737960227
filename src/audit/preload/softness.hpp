#pragma once
// Numbers of ODE that are per step: what they are at a step k times smaller, when the spring, damper or drag that they
// stand for stays.
#include <ode/ode.h>

#include "audit/preload/worlds.hpp"

namespace odeval::audit {

/// A spring kp and damper kd are ERP = h kp / (h kp + kd) and CFM = 1 / (h kp + kd) (ODE's manual). In terms of the
/// numbers at h, those at h/k do not need h.
struct Softness {
  dReal erp;
  dReal cfm;
};
Softness at_part_of_step(Softness at_h, int k);

/// Of a contact: its own, or the world's.
Softness softness_of(const dSurfaceParameters& surface, dWorldID world);

/// A contact's own, where it has one; what it has none of is the world's.
void soften(dSurfaceParameters& surface, Softness world, int k);

/// While it lives: the world, its joints and its bodies have the numbers for h/k.
class Softened {
 public:
  Softened(World& world, int k);
  ~Softened();
  Softened(const Softened&) = delete;
  Softened& operator=(const Softened&) = delete;

  /// While the program's callback has the body, which may read and set its numbers.
  void give_own_numbers(Body& body) const;
  void take_own_numbers(Body& body) const;

 private:
  void joints(World& world, int k);

  World& world_;
  int k_;
  Softness before_;
};

}  // namespace odeval::audit
