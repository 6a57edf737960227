#pragma once
// The double pendulums whose trajectories are certified in this folder.
#include <array>
#include <memory>
#include <string_view>

#include "odeval/scenario.hpp"

namespace odeval::reference {

struct CertifiedMotion {
  std::string_view name;  // of the file, without .csv
  std::string_view why;
  double gravity;
  std::array<Link, 2> links;
  std::array<double, 2> q0;
  std::array<double, 2> qd0;

  /// In joint coordinates only.
  Scenario scenario() const {
    Scenario scenario;
    scenario.name = name;
    scenario.duration_s = 10;
    scenario.step_s = 0.01;
    scenario.gravity = gravity;
    scenario.planar = std::make_shared<PlanarView>(PlanarView{.frame = space_frame,
                                                              .links = {links.begin(), links.end()},
                                                              .q0 = {q0.begin(), q0.end()},
                                                              .qd0 = {qd0.begin(), qd0.end()},
                                                              .wall = {}});
    return scenario;
  }
};

/// Times of the rows: the doubles k * 0.01.
inline constexpr SampleGrid certified_grid{0.01, 1, 1001};

/// The doubles written here are the exact parameters.
inline constexpr std::array<CertifiedMotion, 3> certified_motions{{
    {"report_2010",
     "the report's",
     9.81,
     {{{1, 1, 0.1, 0.1}, {1, 1, 0.1, 0.1}}},
     {0.7853981633974483, -0.7853981633974483},
     {0, 0}},
    {"calm",
     "unequal links that swing about hanging",
     9.8,
     {{{1.5, 0.9, 0.08, 0.1}, {0.8, 1.2, 0.12, 0.1}}},
     {-1.3, 0.4},
     {0.2, -0.1}},
    {"violent",
     "unequal links that go over the top",
     9.81,
     {{{0.8, 0.7, 0.05, 0.1}, {2.2, 1.1, 0.2, 0.1}}},
     {2.5, -1.2},
     {1.5, -4.0}},
}};

}  // namespace odeval::reference
