#pragma once
// A mass on a spring and a damper, in one direction: as time flows, and as ODE steps it.
namespace odeval::reference {

/// From where the spring is at rest, and the rate of that.
struct Deflection {
  double x = 0;
  double v = 0;
};

/// m x'' = -kp x - kd x' - m g. Any damping; without a spring (kp = 0) the mass sinks.
struct DampedOscillator {
  double mass_kg = 1;
  double kp_N_m = 0;
  double kd_Ns_m = 0;
  double gravity = 0;  // m/s², towards -x

  /// Closed form, at any time, before the start as well.
  Deflection at(double t, const Deflection& start) const;

  /// Of spring and damper on the mass, N.
  double force(const Deflection& now) const { return -kp_N_m * now.x - kd_Ns_m * now.v; }

  /// Bound on the rounding of `at`'s x, m: tests/oracle/spring_joint_test.cpp holds it against more digits.
  double uncertainty(double t, const Deflection& start) const;
};

/// One step of ODE with one row of a joint. The row asks for a velocity after the step of -ERP/h x, less CFM times the
/// force (ODE's manual, "How to use ERP and CFM"); then the mass moves with that velocity:
///
///   v' = v + h (f/m - g),   v' + CFM f = -ERP/h x,   x' = x + h v'
///
/// With CFM = 0 that is x' = (1 - ERP) x. With ERP and CFM of a spring (report, eqs. 3.6 and 3.7) f = -kp x' - kd v':
/// the implicit Euler method.
struct StepLaw {
  double mass_kg = 1;
  double erp = 0;
  double cfm = 0;
  double gravity = 0;
  double step_s = 0;

  Deflection next(const Deflection& now) const;
};

}  // namespace odeval::reference
