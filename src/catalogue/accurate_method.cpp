#include "catalogue/accurate_method.hpp"

#include <stdexcept>

#include "engines/ode/module.hpp"
#include "engines/ode_rk4/accurate_step.hpp"

namespace odeval::catalogue {
namespace {

class AccurateStepper final : public engine_ode::WorldStepper {
 public:
  AccurateStepper(const engine_ode::SteppedWorld& world, int order, int parts)
      : parts_(parts), step_(world.world, world.space, options(world, order)) {}

  void step(double h) override {
    for (int k = 0; k < parts_; ++k) {
      before_s_ = k * (h / parts_);
      step_(h / parts_);
    }
  }

 private:
  AccurateStepOptions options(const engine_ode::SteppedWorld& world, int order) {
    AccurateStepOptions options;
    options.order = order;
    if (world.contact) {
      options.contact = [of = world.contact](dxGeom* first, dxGeom* second) -> std::optional<Bounce> {
        const std::optional<engine_ode::Touching> touching = of(first, second);
        return touching ? std::optional(Bounce{touching->restitution, touching->friction}) : std::nullopt;
      };
    }
    if (world.loads) options.forces = [this, load = world.loads](double t) { load(before_s_ + t); };
    options.before_impact = [this, tell = world.before_impact](const Touch& touch) { tell(before_s_ + touch.t); };
    options.after_impact = [tell = world.after_impact](const Touch&) { tell(); };
    return options;
  }

  int parts_;
  double before_s_ = 0;  // of the step, before the part at work
  AccurateStep step_;
};

template <int order, int parts>
std::unique_ptr<engine_ode::WorldStepper> stepper(const engine_ode::SteppedWorld& world) {
  return std::make_unique<AccurateStepper>(world, order, parts);
}

template <int order, int parts = 1>
std::unique_ptr<Simulation> make(const Scenario& scenario, const SampleGrid& grid) {
  Scenario whole = scenario;
  whole.ode.gyroscopic = true;  // of [ode] it obeys the bounce alone
  whole.ode.rotation = Turning::infinitesimal;
  whole.step_s = grid.step_s / parts;  // at which ERP and CFM are the suspension's spring and damper
  return engine_ode::odeval_ode_double().make_stepped(whole, grid, &stepper<order, parts>);
}

}  // namespace

std::unique_ptr<Simulation> make_accurate_4(const Scenario& scenario, const SampleGrid& grid) {
  return make<4>(scenario, grid);
}
std::unique_ptr<Simulation> make_accurate_8(const Scenario& scenario, const SampleGrid& grid) {
  return make<8>(scenario, grid);
}

std::unique_ptr<Simulation> make_accurate_8_in_parts(const Scenario& scenario, const SampleGrid& grid, int parts) {
  switch (parts) {
    case 1:
      return make<8>(scenario, grid);
    case 2:
      return make<8, 2>(scenario, grid);
    case 4:
      return make<8, 4>(scenario, grid);
    case 8:
      return make<8, 8>(scenario, grid);
    default:
      throw std::logic_error("a step is taken in 1, 2, 4 or 8 parts");
  }
}

}  // namespace odeval::catalogue
