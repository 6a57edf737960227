#include "reference/providers.hpp"

#include <algorithm>
#include <array>

#include "odeval/error.hpp"
#include "reference/closed_form/body_motion.hpp"
#include "reference/closed_form/body_solution.hpp"
#include "reference/planar/reference_solution.hpp"
#ifdef ODEVAL_HAVE_SIMBODY
#include "reference/tree/tree_reference.hpp"
#endif

namespace odeval::reference {
namespace {

constexpr Features known_of_chains{Feature::several_links, Feature::many_links, Feature::wall,
                                   Feature::wall_of_several};

/// Whether the mechanism is still what the view says of it.
bool is_of(const PlanarView& view, const Mechanism& mechanism) {
  if (view.links.size() != mechanism.bodies.size() || view.wall.has_value() == mechanism.contacts.empty()) return false;
  for (std::size_t i = 0; i < view.links.size(); ++i) {
    if (view.links[i].mass_kg != mechanism.bodies[i].mass_kg) return false;
  }
  return std::ranges::all_of(mechanism.joints, [](const Joint& joint) { return joint.opening_m == Vec3{}; });
}

/// Any number of links; against a wall one box, or two balls.
bool chain_in_plane(const Scenario& scenario) {
  if (!scenario.planar || !(features_of(scenario) - known_of_chains).empty()) return false;
  const PlanarView& view = *scenario.planar;
  if (!is_of(view, scenario.mechanism)) return false;
  const LinkShape touches = view.links.size() == 1 ? LinkShape::box : LinkShape::sphere;
  const auto may_touch = [&](const Link& link) { return link.shape == touches; };
  return !view.wall || (view.links.size() <= 2 && std::ranges::all_of(view.links, may_touch));
}

// One link has a closed form as well, without a bound on its error: there `analytic` is a method to compare.
constexpr std::array table{
    ReferenceProvider{"analytic", has_body_motion, solve_body_reference},
    ReferenceProvider{"lagrange-cvode", chain_in_plane, solve_reference},
#ifdef ODEVAL_HAVE_SIMBODY
    ReferenceProvider{"mechanism-cvode", is_tree, solve_tree, true},
#endif
};

#ifdef ODEVAL_HAVE_SIMBODY
constexpr Features known = known_of_bodies | known_of_chains | known_of_trees;
constexpr std::string_view mechanisms = ", bodies on joints that start closed";
constexpr std::string_view without = "";
#else
constexpr Features known = known_of_bodies | known_of_chains;
constexpr std::string_view mechanisms = "";
constexpr std::string_view without = "; this build has no Simbody (libsimbody-dev), which bodies on joints need";
#endif

}  // namespace

std::span<const ReferenceProvider> providers() { return table; }

#ifdef ODEVAL_HAVE_SIMBODY
const MakeSimulation mechanism_cvode = make_mechanism_cvode;
#else
const MakeSimulation mechanism_cvode = nullptr;
#endif

const ReferenceProvider& provider_for(const Scenario& scenario) {
  const auto* const found =
      std::ranges::find_if(table, [&](const ReferenceProvider& provider) { return provider.supports(scenario); });
  if (found != table.end()) return *found;
  const Features missing = features_of(scenario) - known;
  if (!missing.empty()) {
    throw UserError(scenario.file + ": there is no reference for what has " + listed(missing) + std::string(without));
  }
  throw UserError(scenario.file +
                  ": there is no reference for these bodies, joints and contacts together: there are references of " +
                  "chains in a plane (against a wall one box, or two balls), bodies alone, one or two bodies on one " +
                  "joint, balls on a plane, and a box that rubs on one" + std::string(mechanisms) +
                  std::string(without));
}

std::function<Reference(const SampleGrid&)> follow([[maybe_unused]] const Scenario& scenario) {
#ifdef ODEVAL_HAVE_SIMBODY
  const bool sampled = std::ranges::any_of(scenario.mechanism.joints, &Joint::sampled);
  if (provider_for(scenario).supports == is_tree && !sampled) return follow_tree(scenario);
#endif
  return {};
}

Scenario half_a_step_earlier(const Scenario& scenario) {
#ifdef ODEVAL_HAVE_SIMBODY
  if (!has_body_motion(scenario) && is_tree(scenario)) return tree_half_a_step_earlier(scenario);
#endif
  return bodies_half_a_step_earlier(scenario);
}

}  // namespace odeval::reference
