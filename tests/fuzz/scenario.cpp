// libFuzzer: whatever a scenario file says, it is read or refused with one line. The text up to a zero byte is the
// file, the rest a setting KEY=VALUE on top of it.
#include <cstdlib>

#include "model/read_scenario.hpp"
#include "odeval/error.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace odeval;
  static const Names names{{"ode-step-double", "lagrange-rk4"}, {"max_error_q", "max_energy_drift"}};
  const std::string_view all(reinterpret_cast<const char*>(data), size);
  const std::size_t zero = all.find('\0');
  std::vector<Override> settings;
  if (zero != std::string_view::npos) {
    const std::string setting(all.substr(zero + 1));
    const std::size_t equals = setting.find('=');
    if (equals != std::string::npos)
      settings.push_back({setting.substr(0, equals), setting.substr(equals + 1), "--set"});
  }
  try {
    const ScenarioFile file("fuzz.toml", all.substr(0, zero));
    const Scenario scenario = file.read(settings, names);
    if (sample_grid(scenario).rows < 1) std::abort();
    ScenarioFile("fuzz.toml", file.text(settings)).read({}, names);  // its own spelling is as good
  } catch (const UserError& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) std::abort();
  }
  return 0;
}
