#include "catalogue/accurate_method.hpp"

#include "engines/ode/module.hpp"
#include "engines/ode_rk4/accurate_step.hpp"

namespace odeval::catalogue {
namespace {

class AccurateStepper final : public engine_ode::WorldStepper {
 public:
  explicit AccurateStepper(const engine_ode::SteppedWorld& world) : step_(world.world, world.space, options(world)) {}

  void step(double h) override { step_(h); }

 private:
  static AccurateStepOptions options(const engine_ode::SteppedWorld& world) {
    AccurateStepOptions options;
    if (world.contact) {
      options.contact = [of = world.contact](dxGeom* first, dxGeom* second) -> std::optional<Bounce> {
        const std::optional<engine_ode::Touching> touching = of(first, second);
        return touching ? std::optional(Bounce{touching->restitution, touching->friction}) : std::nullopt;
      };
    }
    options.forces = world.loads;
    options.before_impact = [tell = world.before_impact](const Touch& touch) { tell(touch.t); };
    options.after_impact = [tell = world.after_impact](const Touch&) { tell(); };
    return options;
  }

  AccurateStep step_;
};

std::unique_ptr<engine_ode::WorldStepper> stepper(const engine_ode::SteppedWorld& world) {
  return std::make_unique<AccurateStepper>(world);
}

}  // namespace

std::unique_ptr<Simulation> make_accurate(const Scenario& scenario, const SampleGrid& grid) {
  Scenario whole = scenario;
  whole.ode.gyroscopic = true;  // of [ode] it obeys the bounce alone
  return engine_ode::odeval_ode_double().make_stepped(whole, grid, &stepper);
}

}  // namespace odeval::catalogue
