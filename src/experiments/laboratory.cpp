#include <algorithm>

#include "experiments/experiment.hpp"

namespace odeval::experiments {

Laboratory::Laboratory(std::function<Scenario(const std::string& name)> read) : read_(std::move(read)) {}

Laboratory::Case& Laboratory::at(const std::string& name) {
  Case& wanted = cases_[name];
  if (!wanted.evaluator) wanted.evaluator = std::make_unique<catalogue::Evaluator>(read_(name));
  return wanted;
}

const Scenario& Laboratory::scenario(const std::string& name) { return at(name).evaluator->scenario(); }

catalogue::Evaluator& Laboratory::evaluator(const std::string& name) { return *at(name).evaluator; }

const catalogue::Evaluation* Laboratory::run(const std::string& name, std::string_view method) {
  const catalogue::Method* const row = available(method);
  if (row == nullptr) return nullptr;
  Case& wanted = at(name);
  const auto found = wanted.runs.find(method);
  if (found != wanted.runs.end()) {
    catalogue::Suspects::note(found->second, wanted.evaluator->scenario());  // of each section that shows the run
    return &found->second;
  }
  return &wanted.runs.emplace(std::string(method), wanted.evaluator->evaluate(*row)).first->second;
}

const catalogue::Method* available(std::string_view method) {
  const auto all = catalogue::methods();
  const auto found = std::ranges::find(all, method, &catalogue::Method::name);
  return found == all.end() || found->make == nullptr ? nullptr : &*found;
}

int colour_of(std::string_view method) {
  static constexpr std::string_view coloured[report::method_colours] = {
      "ode-step-double",           "ode-step-single", "ode-quickstep-double",
      "ode-quickstep-single",      "ode-rk4-double",  "lagrange-ode45",
      catalogue::reference_method, "lagrange-rk4",    "lagrange-euler",
      "lagrange-symplectic-euler", "maximal-euler",   "maximal-rk4"};
  const auto* const found = std::ranges::find(coloured, method);
  return found == std::end(coloured) ? report::rest_colour : static_cast<int>(found - coloured);
}

Column thinned(const Column& column, std::size_t most) {
  if (column.size() <= most) return column;
  Column few(most);
  for (std::size_t i = 0; i < most; ++i) few[i] = column[i * (column.size() - 1) / (most - 1)];
  return few;
}

}  // namespace odeval::experiments
