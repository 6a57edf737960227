#include <array>

#include "experiments/all.hpp"

namespace odeval::experiments {
namespace {

constexpr std::array table{
    Experiment{"snapshots", "Pictures of the motions", snapshots},
};

}  // namespace

std::span<const Experiment> experiments() { return table; }

}  // namespace odeval::experiments
