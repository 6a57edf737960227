#pragma once
// What Bullet's worlds have in common of settings.
#include <btBulletDynamicsCommon.h>

#include <string>

#include "odeval/scenario.hpp"
#include "odeval/told.hpp"

namespace odeval::engine_bullet {

/// Every number of the solver that acts on joints and contacts, as Bullet has them where no setting says.
inline void set(btContactSolverInfo& solver, const BulletSettings& settings) {
  solver.m_numIterations = settings.iterations;
  solver.m_erp = btScalar(settings.erp);
  solver.m_erp2 = btScalar(settings.erp);  // of contacts
  solver.m_frictionERP = btScalar(0.2);
  solver.m_frictionCFM = 0;
  solver.m_maxErrorReduction = 20;
  solver.m_splitImpulse = 1;
  solver.m_splitImpulsePenetrationThreshold = btScalar(-0.04);
  solver.m_splitImpulseTurnErp = btScalar(0.1);
  solver.m_linearSlop = 0;
  solver.m_restitutionVelocityThreshold = btScalar(0.2);
  solver.m_articulatedWarmstartingFactor = btScalar(0.85);
  solver.m_globalCfm = 0;
  solver.m_tau = btScalar(0.6);
  solver.m_damping = 1;
  solver.m_sor = 1;
  solver.m_warmstartingFactor = btScalar(0.85);
  solver.m_leastSquaresResidualThreshold = 0;
  solver.m_numNonContactInnerIterations = 1;
  solver.m_jointFeedbackInWorldSpace = false;
  solver.m_jointFeedbackInJointFrame = false;
  solver.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_SIMD | SOLVER_USE_2_FRICTION_DIRECTIONS;
}

/// The same, read back.
inline Told common(const btContactSolverInfo& solver) {
  const std::int64_t version = btGetVersion();
  return {
      {"version", std::to_string(version / 100) + "." + std::to_string(version % 100)},
      {"precision", std::string(sizeof(btScalar) == sizeof(double) ? "double" : "single")},
      {"iterations", std::int64_t{solver.m_numIterations}},
      {"erp", double(solver.m_erp)},
      {"global_cfm", double(solver.m_globalCfm)},
      {"tau", double(solver.m_tau)},
      {"damping", double(solver.m_damping)},
      {"sor", double(solver.m_sor)},
      {"warm_starting", double((solver.m_solverMode & SOLVER_USE_WARMSTARTING) != 0 ? solver.m_warmstartingFactor : 0)},
      {"residual_threshold", double(solver.m_leastSquaresResidualThreshold)},
      {"friction_directions", std::int64_t{(solver.m_solverMode & SOLVER_USE_2_FRICTION_DIRECTIONS) != 0 ? 2 : 1}},
      {"contact_erp", double(solver.m_erp2)},
      {"restitution_threshold", double(solver.m_restitutionVelocityThreshold)},
      {"split_impulse", std::string(solver.m_splitImpulse != 0 ? "on" : "off")},
      {"split_impulse_threshold", double(solver.m_splitImpulsePenetrationThreshold)},
      {"split_impulse_turn_erp", double(solver.m_splitImpulseTurnErp)},
      {"friction_erp", double(solver.m_frictionERP)},
      {"friction_cfm", double(solver.m_frictionCFM)},
      {"max_error_reduction", double(solver.m_maxErrorReduction)},
      {"linear_slop", double(solver.m_linearSlop)},
      {"articulated_warm_starting", double(solver.m_articulatedWarmstartingFactor)},
      {"contact_breaking_threshold", double(gContactBreakingThreshold)},
      {"inner_iterations", std::int64_t{solver.m_numNonContactInnerIterations}}};
}

}  // namespace odeval::engine_bullet
