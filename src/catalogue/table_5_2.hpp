#pragma once
// What the report's Table 5.2 holds (section 5.7.1; cases as in its Table 5.1), and who stands for each case today.
#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "odeval/scenario.hpp"
#include "output/timing.hpp"

namespace odeval::catalogue {

/// A case over 10 s on the machine of 2010.
struct Case2010 {
  int number;
  std::string_view coordinates;
  std::string_view equations;
  std::string_view solver;
  int steps;  // ode45: points, of which its default makes four a step
  double seconds;
  std::string_view method;  // of this program
};

inline constexpr int ode45_refine = 4;

// clang-format off
inline constexpr std::array table_5_2{
    Case2010{1, "generalized", "toolbox, interpreted",  "ode45", 500,   6.60, "dh-ode45"},
    Case2010{2, "generalized", "toolbox, compiled",     "ode45", 500,   1.13, "dh-ode45"},
    Case2010{3, "generalized", "derived by hand",       "ode45", 500,   0.35, "lagrange-ode45"},
    Case2010{4, "generalized", "derived by hand",       "Euler", 10000, 1.13, "lagrange-euler"},
    Case2010{5, "Cartesian",   "ODE",                   "ODE's", 10000, 0.29, "ode-step-double"},
};
// clang-format on

/// What the report did not have: shown below its cases.
inline constexpr std::array beside_table_5_2{std::string_view("lagrange-cvode"), std::string_view("lagrange-rk4"),
                                             std::string_view("ode-rk4-double")};

/// Whether the motion is that of the report's double pendulum (D.3) over its 10 s, whatever the settings.
bool is_of_table_5_2(const Scenario& scenario);

/// Table 5.2 beside the times of today. `rows` holds one row a method; a method without one keeps its place.
std::vector<Table52Row> table_5_2_rows(std::span<const TimingRow> rows);

}  // namespace odeval::catalogue
