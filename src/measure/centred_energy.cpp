#include "measure/centred_energy.hpp"

namespace odeval {

Column centred_kinetic(const Scenario& scenario, const Trace& trace) {
  const Vec3 axis = scenario.planar->frame.axis();
  Column kinetic(trace.rows() > 0 ? trace.rows() - 1 : 0);
  for (std::size_t i = 0; i < trace.bodies.size(); ++i) {
    const BodyColumns& body = trace.bodies[i];
    const Link& link = scenario.planar->links[i];
    for (std::size_t k = 0; k < kinetic.size(); ++k) {
      double speed_squared = 0;
      double spin = 0;
      for (std::size_t d = 0; d < 3; ++d) {
        const double velocity = (body.velocity[d][k] + body.velocity[d][k + 1]) / 2;
        speed_squared += velocity * velocity;
        spin += axis[d] * (body.spin[d][k] + body.spin[d][k + 1]) / 2;
      }
      kinetic[k] += (link.mass_kg * speed_squared + link.inertia_kgm2() * spin * spin) / 2;
    }
  }
  return kinetic;
}

Column centred_energy_drift(const Scenario& scenario, const Trace& trace) {
  Column drift = centred_kinetic(scenario, trace);
  for (std::size_t k = 0; k < drift.size(); ++k) {
    drift[k] += trace.potential[k] - (trace.kinetic.front() + trace.potential.front());
  }
  return drift;
}

}  // namespace odeval
