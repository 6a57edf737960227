#pragma once
// What was made of a robot's file, and what was not taken: for people, and for programs.
#include <cstddef>
#include <string>

#include "odeval/import_proof.hpp"
#include "odeval/robot.hpp"

namespace odeval {

/// The one table of what was read by a rule or not taken, and before it the proof. `bodies` is how many the scenario
/// has.
std::string import_report(const Robot& robot, std::size_t bodies, const ImportProof& proof);
/// The same, with every name.
std::string import_json(const std::string& file, const Robot& robot, std::size_t bodies, const ImportProof& proof);

}  // namespace odeval
