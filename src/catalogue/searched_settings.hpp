#pragma once
// What a search for the cheapest settings of a method tries: those that the method reads.
#include <array>
#include <span>
#include <string>
#include <string_view>

#include "odeval/scenario.hpp"
#include "output/number.hpp"

namespace odeval::catalogue {

struct SearchedSetting {
  std::string_view key;
  bool together;  // tried in every combination with the others, since they act on the same error
  std::span<const std::string_view> values;
  std::string (*own)(const Scenario&);
};

namespace tried {

// The values that promise most stand first, so that the rest need one run each to be
// seen to be no better.
inline constexpr std::array<std::string_view, 2> starts{"half-step", "as-given"};
inline constexpr std::array<std::string_view, 7> erps{"1", "0.8", "0.6", "0.4", "0.2", "0.1", "0.9"};
inline constexpr std::array<std::string_view, 2> rotations{"finite", "infinitesimal"};
inline constexpr std::array<std::string_view, 2> axes{"sliding", "plane-space"};
inline constexpr std::array<std::string_view, 4> cfms{"1e-10", "1e-08", "1e-06", "1e-05"};
inline constexpr std::array<std::string_view, 6> iterations{"5", "10", "20", "40", "80", "160"};
inline constexpr std::array<std::string_view, 5> sor_ws{"1", "1.2", "1.4", "1.6", "1.8"};
// Of other engines. No step is longer than half of MuJoCo's time constant.
inline constexpr std::array<std::string_view, 6> time_constants_s{"0.005", "0.002", "0.01", "0.02", "0.05", "0.001"};
inline constexpr std::array<std::string_view, 2> cones{"elliptic", "pyramidal"};
inline constexpr std::array<std::string_view, 4> bullet_erps{"0", "0.1", "0.2", "0.8"};
inline constexpr std::array<std::string_view, 5> bullet_iterations{"5", "10", "30", "100", "1000"};

}  // namespace tried

inline constexpr std::array searched_settings{
    SearchedSetting{
        "ode.start", true, tried::starts,
        [](const Scenario& s) { return std::string(s.ode.start == Start::half_step ? "half-step" : "as-given"); }},
    SearchedSetting{"ode.erp", true, tried::erps, [](const Scenario& s) { return number_text(s.ode.erp); }},
    SearchedSetting{
        "ode.rotation", true, tried::rotations,
        [](const Scenario& s) { return std::string(s.ode.rotation == Turning::finite ? "finite" : "infinitesimal"); }},
    SearchedSetting{"ode.friction_axes", true, tried::axes,
                    [](const Scenario& s) {
                      return std::string(s.ode.friction_axes == FrictionAxes::sliding ? "sliding" : "plane-space");
                    }},
    SearchedSetting{"ode.cfm", false, tried::cfms, [](const Scenario& s) { return number_text(s.ode.cfm); }},
    SearchedSetting{"ode.iterations", false, tried::iterations,
                    [](const Scenario& s) { return std::to_string(s.ode.iterations); }},
    SearchedSetting{"ode.sor_w", false, tried::sor_ws, [](const Scenario& s) { return number_text(s.ode.sor_w); }},
    SearchedSetting{"mujoco.cone", true, tried::cones,
                    [](const Scenario& s) { return std::string(s.mujoco.elliptic ? "elliptic" : "pyramidal"); }},
    SearchedSetting{"mujoco.time_constant", true, tried::time_constants_s,
                    [](const Scenario& s) { return number_text(s.mujoco.time_constant_s); }},
    SearchedSetting{"bullet.erp", true, tried::bullet_erps,
                    [](const Scenario& s) { return number_text(s.bullet.erp); }},
    SearchedSetting{"bullet.iterations", false, tried::bullet_iterations,
                    [](const Scenario& s) { return std::to_string(s.bullet.iterations); }},
};

}  // namespace odeval::catalogue
