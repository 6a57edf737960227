#pragma once
// The experiments, one function a file; the table in experiments.cpp puts them in order.
#include "experiments/experiment.hpp"

namespace odeval::experiments {

using report::Findings;
using report::Section;

Section snapshots(Laboratory& laboratory, Findings& findings);

}  // namespace odeval::experiments
