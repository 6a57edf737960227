#pragma once
// Generators: from few numbers to a mechanism with its views.
#include <memory>
#include <utility>
#include <vector>

#include "model/description.hpp"
#include "odeval/scenario.hpp"

namespace odeval {

/// Puts a planar chain into the scenario: the view, its mechanism (one body a link, one hinge a link, the wall as a box
/// where there is one) and how impacts on the wall are told.
///
/// Built the way the report's listings C.2 and C.5 build it: the first link is the first body of its hinge, to the
/// world; every other link is the second, after its parent.
void put_planar(Scenario& scenario, PlanarView view);

/// The same with a view that is changed first: change_planar(scenario, [](PlanarView& view) { view.q0[0] = 1; }).
template <class Change>
void change_planar(Scenario& scenario, Change&& change) {
  PlanarView view = *scenario.planar;
  std::forward<Change>(change)(view);
  put_planar(scenario, std::move(view));
}

/// Puts the bodies of a description into the scenario, with its ground or its joint.
void put_bodies(Scenario& scenario, const Description& description);

/// A plane through the origin that falls towards +x by so much.
HalfSpace sloping(double slope_rad);

/// The scenario's ground falls by another slope; impacts are told along it.
void set_slope(Scenario& scenario, double slope_rad);

/// What the file said of the mechanism, completed.
Definition definition_of(const Description& description);

}  // namespace odeval
