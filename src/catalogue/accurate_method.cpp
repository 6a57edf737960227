#include "catalogue/accurate_method.hpp"

#include "engines/ode/module.hpp"
#include "engines/ode_rk4/accurate_step.hpp"

namespace odeval::catalogue {
namespace {

class AccurateStepper final : public engine_ode::WorldStepper {
 public:
  AccurateStepper(const engine_ode::SteppedWorld& world, int order)
      : step_(world.world, world.space, options(world, order)) {}

  void step(double h) override { step_(h); }

 private:
  static AccurateStepOptions options(const engine_ode::SteppedWorld& world, int order) {
    AccurateStepOptions options;
    options.order = order;
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

template <int order>
std::unique_ptr<engine_ode::WorldStepper> stepper(const engine_ode::SteppedWorld& world) {
  return std::make_unique<AccurateStepper>(world, order);
}

template <int order>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid) {
  Scenario whole = scenario;
  whole.ode.gyroscopic = true;  // of [ode] it obeys the bounce alone
  return engine_ode::odeval_ode_double().make_stepped(whole, grid, &stepper<order>);
}

}  // namespace

std::unique_ptr<Simulation> make_accurate_4(const Scenario& scenario, const SampleGrid& grid) {
  return make<4>(scenario, grid);
}
std::unique_ptr<Simulation> make_accurate_8(const Scenario& scenario, const SampleGrid& grid) {
  return make<8>(scenario, grid);
}

}  // namespace odeval::catalogue
