// Simbody alone.
#include <Simbody.h>

#include <memory>
#include <string>

#include "tests/benchmark/bare_engine.h"

namespace {

struct Pendulum {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  SimTK::MobilizedBody first, last;
  std::unique_ptr<SimTK::Integrator> integrator;
  bool chooses;

  // Pins turn about z, links about x.
  explicit Pendulum(const std::string& method) : chooses(method == "simbody-merson") {
    using SimTK::Transform;
    SimTK::Force::Gravity(forces, matter, SimTK::Vec3(0, 0, -9.81));
    const SimTK::Body::Rigid link(
        SimTK::MassProperties(1, SimTK::Vec3(0), SimTK::Inertia(1.01 / 12, 0.02 / 12, 1.01 / 12)));
    const SimTK::Rotation z_along_x(SimTK::UnitVec3(1, 0, 0), SimTK::ZAxis);
    const auto at = [&](double y, double z) { return Transform(z_along_x, SimTK::Vec3(0, y, z)); };
    first = SimTK::MobilizedBody::Pin(matter.updGround(), at(0, 2.1), link, at(-0.5, 0));
    last = SimTK::MobilizedBody::Pin(first, at(0.5, 0), link, at(-0.5, 0));
    system.realizeTopology();
    SimTK::State state = system.getDefaultState();
    first.setOneQ(state, 0, SimTK::Pi / 4);
    last.setOneQ(state, 0, -SimTK::Pi / 4);
    if (chooses) {
      integrator = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
    } else {
      integrator = std::make_unique<SimTK::SemiExplicitEulerIntegrator>(system, 1e-3);
      integrator->setAllowInterpolation(false);
    }
    integrator->initialize(state);
  }
};

std::unique_ptr<Pendulum> pendulum;
long done;

}  // namespace

void bare_create(const char* method) {
  pendulum = std::make_unique<Pendulum>(method);
  done = 0;
}

void bare_run(long steps) {
  const long end = done + steps;
  if (pendulum->chooses) done = end - 1;
  SimTK::Integrator& integrator = *pendulum->integrator;
  while (done < end) {
    const double until = static_cast<double>(++done) * 1e-3;
    while (integrator.getTime() < until) integrator.stepTo(until);
  }
}

double bare_height() {
  const SimTK::State& state = pendulum->integrator->getState();
  pendulum->system.realize(state, SimTK::Stage::Position);
  return pendulum->last.getBodyOriginLocation(state)[2];
}

void bare_destroy() { pendulum.reset(); }
