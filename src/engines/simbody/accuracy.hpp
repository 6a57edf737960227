#pragma once

namespace odeval::engine_simbody {

/// Simbody's own accuracy where nothing is asked.
inline constexpr double default_accuracy = 1e-3;

}  // namespace odeval::engine_simbody
