#pragma once
// Of the library with the simulated clock: it is there when that is loaded.
#include <atomic>

/// s, of the world that went farthest, as the program has it between its steps.
extern "C" __attribute__((weak)) std::atomic<double> odeval_simulated_s;
/// Whether the program has read it, or slept.
extern "C" __attribute__((weak)) std::atomic<bool> odeval_clock_asked;
