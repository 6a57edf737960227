#pragma once
// How ODE holds what it holds, a joint or a contact: by numbers of its own, or as a spring and a damper.
//
// Source: the report, eqs. 3.6 and 3.7, which are those of ODE's manual ("How To Use ERP and CFM"). Units are SI, of a
// row along a line; of a turn read N m s/rad for N s/m and so on.

namespace odeval {

/// The part of an error that a step takes back, and how far a force opens what is held.
struct Softness {
  double erp = 0;  // 0 to 1
  double cfm = 0;  // s/kg, of a linear row: m/s that 1 N of force opens it by
};

/// The same as a spring and a damper.
struct Spring {
  double kp_N_m = 0;   // stiffness
  double kd_Ns_m = 0;  // damping
};

/// Eqs. 3.6 and 3.7. The same spring is another softness at another step.
constexpr Softness softness_of(const Spring& spring, double step_s) {
  const double stiffness = step_s * spring.kp_N_m + spring.kd_Ns_m;
  return {step_s * spring.kp_N_m / stiffness, 1 / stiffness};
}

/// The other way round. Without CFM what is held is stiffer than any spring: infinite or not a number.
constexpr Spring spring_of(const Softness& softness, double step_s) {
  return {softness.erp / (step_s * softness.cfm), (1 - softness.erp) / softness.cfm};
}

}  // namespace odeval
