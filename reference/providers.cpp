#include "reference/providers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "odeval/error.hpp"
#include "reference/bodies/motion.hpp"
#include "reference/bodies/solution.hpp"
#include "reference/reference_solution.hpp"

namespace odeval::reference {
namespace {

/// Bodies without joint coordinates. (One link has a closed form as well, which shows no more digits than CVODE and no
/// bound on its error: there `analytic` is a method to compare.)
bool bodies_in_closed_form(const Scenario& scenario) { return !scenario.planar && has_body_motion(scenario); }

bool is_free(const Joint& joint) { return !joint.motor && !joint.stop; }

bool chain_in_plane(const Scenario& scenario) {
  if (!scenario.planar || !std::ranges::all_of(scenario.mechanism.joints, is_free)) return false;
  const PlanarView& view = *scenario.planar;
  const LinkShape touches = view.links.size() == 1 ? LinkShape::box : LinkShape::sphere;
  const auto may_touch = [&](const Link& link) { return link.shape == touches; };
  return !view.wall || (view.links.size() <= 2 && std::ranges::all_of(view.links, may_touch));
}

constexpr std::array table{
    ReferenceProvider{"analytic", bodies_in_closed_form, solve_body_reference},
    ReferenceProvider{"lagrange-cvode", chain_in_plane, solve_reference},
};

}  // namespace

std::span<const ReferenceProvider> providers() { return table; }

const ReferenceProvider& provider_for(const Scenario& scenario) {
  const auto* const found =
      std::ranges::find_if(table, [&](const ReferenceProvider& provider) { return provider.supports(scenario); });
  if (found != table.end()) return *found;
  const Mechanism& mechanism = scenario.mechanism;
  throw UserError(
      fmt::format("{}: no reference knows the motion of bodies: {}, joints: {}, contacts: {} together; there is one "
                  "for chains in a "
                  "plane, for bodies alone, for one joint, and for contacts with one plane",
                  scenario.file, mechanism.bodies.size(), mechanism.joints.size(), mechanism.contacts.size()));
}

}  // namespace odeval::reference
