// libFuzzer: whatever a robot's file says, it is read or refused with one line; what is read is a scenario, or refused
// with one line. The first byte chooses the format.
#include <cstdlib>

#include "model/import_robot.hpp"
#include "model/read_scenario.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace odeval;
  static const Names names{{"ode-step-double", "ode-quickstep-double"}, {}};
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  const char* const file = data[0] % 2 == 0 ? "fuzz.sdf" : "fuzz.urdf";  // a space is even, '!' is odd
  try {
    const Imported imported = import_robot(file, read_robot(file, text), {.base_free = data[0] % 4 == 3});
    const Scenario scenario = ScenarioFile(file, imported.toml).read({}, names);
    if (scenario.mechanism.bodies.empty()) std::abort();
  } catch (const UserError& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) std::abort();
  }
  return 0;
}
