#include "catalogue/import_proof.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>
#include <stdexcept>

#include "engines/ode/module.hpp"
#include "odeval/error.hpp"
#include "reference/tree/joint_space.hpp"

namespace odeval::catalogue {
namespace {

using reference::JointSpace;
using reference::TreeState;

/// The largest difference, and where.
struct Difference {
  double value = 0;
  Eigen::Index row = 0;
};

/// NaN is infinitely far.
void note(Difference& all, double value, Eigen::Index row) {
  if (std::isnan(value)) value = std::numeric_limits<double>::infinity();
  if (value > all.value) all = {value, row};
}

Difference difference(const JointSpace& a, const JointSpace& b) {
  Difference all;
  if (a.mass.rows() != b.mass.rows()) return {std::numeric_limits<double>::infinity(), 0};
  const Eigen::VectorXd scale = a.mass.diagonal().cwiseSqrt();
  const double largest = a.bias.cwiseQuotient(scale).lpNorm<Eigen::Infinity>();
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    for (Eigen::Index j = 0; j < scale.size(); ++j) {
      note(all, std::fabs(a.mass(i, j) - b.mass(i, j)) / (scale[i] * scale[j]), i);
    }
    if (largest > 0) note(all, std::fabs(a.bias[i] - b.bias[i]) / (scale[i] * largest), i);
  }
  return all;
}

/// Far from where anything is singular: angles and ways of at most 1 rad and m, speeds likewise.
TreeState random_state(std::size_t bodies, std::mt19937_64& random) {
  const auto number = [&] { return std::ldexp(static_cast<double>(random() >> 11), -52) - 1; };
  TreeState state(bodies);
  for (auto& [q, u] : state) {
    for (double& x : q) x = number();
    for (double& x : u) x = number();
  }
  return state;
}

std::string body_of_row(const Mechanism& mechanism, Eigen::Index row) {
  const auto tree = reference::spanning_tree(mechanism);
  std::size_t passed = 0;
  const std::vector<std::size_t> speeds = reference::speeds_of(mechanism, tree);
  for (std::size_t b = 0; b < speeds.size(); ++b) {
    passed += speeds[b];
    if (static_cast<std::size_t>(row) < passed) return mechanism.bodies[b].name;
  }
  return "";
}

}  // namespace

ImportProof prove_import(const Imported& imported, const Scenario& scenario, int states) {
  return prove_import(imported, scenario.mechanism, engine_ode::odeval_ode_double().take_back(scenario),
                      scenario.gravity, states);
}

ImportProof prove_import(const Imported& imported, const Mechanism& mechanism, const Mechanism& held, double gravity,
                         int states) {
  ImportProof proof{.states = states};
  if (std::ranges::any_of(reference::spanning_tree(held), &reference::Branch::again))
    throw MachineError("what ODE holds is no tree, and the robot is one");
  Difference worst;
  std::mt19937_64 random(1);
  const auto compare = [&](std::optional<double>& of, const JointSpace& other, const JointSpace& ode) {
    const Difference found = difference(other, ode);
    of = std::fmax(of.value_or(0), found.value);
    if (found.value >= worst.value) worst = found;
  };
  for (int i = 0; i < states; ++i) {
    const TreeState state = random_state(mechanism.bodies.size(), random);
    const JointSpace ode = reference::joint_space_of(held, state, gravity);
    if (const auto simbody = reference::joint_space_by_simbody(mechanism, state, gravity)) {
      compare(proof.simbody, *simbody, ode);
    } else {
      proof.without = "Simbody is not in this build";
    }
    try {
      compare(proof.kdl, reference::joint_space_by_kdl(imported.robot, imported.body_of, mechanism, state, gravity),
              ode);
    } catch (const std::domain_error& why) {
      proof.without = why.what();
    }
  }
  proof.worst = body_of_row(mechanism, worst.row);
  return proof;
}

void require_proved(const ImportProof& proof, const Scenario& scenario) {
  if (proof.holds()) return;
  std::ostringstream text;
  text.precision(3);
  text << scenario.file << ": the import is not proved: at '" << proof.worst
       << "' mass matrix or bias forces of the ODE world differ from those of";
  if (proof.simbody) text << " Simbody by " << *proof.simbody;
  if (proof.kdl) text << (proof.simbody ? " and" : "") << " KDL by " << *proof.kdl;
  text << "; at most " << ImportProof::allowed << " is rounding";
  throw MachineError(text.str());
}

}  // namespace odeval::catalogue
