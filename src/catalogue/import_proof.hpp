#pragma once
// The proof of an import, before any motion.
#include "model/import_robot.hpp"
#include "odeval/import_proof.hpp"
#include "odeval/scenario.hpp"

namespace odeval::catalogue {

/// The mechanism of the scenario that was made of the robot. `held` is what an engine has of it, by default ODE in
/// double precision. Repeats to the bit. Throws nothing for a proof that fails.
ImportProof prove_import(const Imported& imported, const Scenario& scenario, int states = 20);
ImportProof prove_import(const Imported& imported, const Mechanism& mechanism, const Mechanism& held, double gravity,
                         int states = 20);

/// Throws MachineError, which names the largest difference, for a proof that fails.
void require_proved(const ImportProof& proof, const Scenario& scenario);

}  // namespace odeval::catalogue
