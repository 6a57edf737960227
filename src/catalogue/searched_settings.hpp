#pragma once
// What a search for the cheapest settings tries of ODE's.
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
  std::string (*own)(const OdeSettings&);
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

}  // namespace tried

inline constexpr std::array searched_settings{
    SearchedSetting{
        "ode.start", true, tried::starts,
        [](const OdeSettings& ode) { return std::string(ode.start == Start::half_step ? "half-step" : "as-given"); }},
    SearchedSetting{"ode.erp", true, tried::erps, [](const OdeSettings& ode) { return number_text(ode.erp); }},
    SearchedSetting{"ode.rotation", true, tried::rotations,
                    [](const OdeSettings& ode) {
                      return std::string(ode.rotation == Turning::finite ? "finite" : "infinitesimal");
                    }},
    SearchedSetting{"ode.friction_axes", true, tried::axes,
                    [](const OdeSettings& ode) {
                      return std::string(ode.friction_axes == FrictionAxes::sliding ? "sliding" : "plane-space");
                    }},
    SearchedSetting{"ode.cfm", false, tried::cfms, [](const OdeSettings& ode) { return number_text(ode.cfm); }},
    SearchedSetting{"ode.iterations", false, tried::iterations,
                    [](const OdeSettings& ode) { return std::to_string(ode.iterations); }},
    SearchedSetting{"ode.sor_w", false, tried::sor_ws, [](const OdeSettings& ode) { return number_text(ode.sor_w); }},
};

}  // namespace odeval::catalogue
