#pragma once
// A setting from the command line that replaces one of the scenario file.
#include <string>
#include <string_view>
#include <vector>

namespace odeval {

struct Override {
  std::string key;     // as in the file, dotted: "duration", "ode.erp", "links.0.mass", "q0", "q0.1"
  std::string value;   // as in the file: 2, [1.0, 0.5], "half-step"; a bare word needs no quotes
  std::string origin;  // what the user typed: --erp, --set
};

/// Whether what stands at the path is at the key or in it: "q0" holds "q0.1", "ode" holds "ode.erp".
constexpr bool is_or_holds(std::string_view key, std::string_view path) {
  return path == key || (path.starts_with(key) && path[key.size()] == '.');
}
/// Whether two keys give one value twice.
constexpr bool overlap(std::string_view a, std::string_view b) { return is_or_holds(a, b) || is_or_holds(b, a); }

/// The setting as the user typed it: `--erp 1.5`, `--set q0=[1.0]`.
std::string typed(const Override& setting);

/// What a check says that knows the file alone, "FILE: KEY must ...", as "--set KEY=VALUE: KEY must ..." where one of
/// the settings gave that key, or else one that the text names later as "KEY is 2". Else as it is.
std::string blamed(const std::string& message, const std::vector<Override>& settings);

}  // namespace odeval
