#pragma once
// Experiments in a pool of processes: ODE's globals allow no threads.
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "experiments/experiment.hpp"
#include "report/section_bytes.hpp"

namespace odeval::experiments {

/// What each experiment leaves, in their order. An experiment that throws or takes its process down leaves a section
/// that says so, and its numbers missing. `finished` hears of each. There is no limit of time. SIGINT, SIGTERM and
/// SIGHUP end this process.
///
/// The processes start with what the laboratory has run already; what they run themselves, each has for itself.
std::vector<report::Outcome> run_side_by_side(std::span<const Experiment> all, Laboratory& laboratory,
                                              unsigned processes,
                                              const std::function<void(const Experiment&)>& finished);

}  // namespace odeval::experiments
