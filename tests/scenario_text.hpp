#pragma once
// Scenario files that tests write down as text: read, changed, refused.
#include <string>
#include <vector>

#include "model/read_scenario.hpp"
#include "odeval/error.hpp"
#include "tests/check.hpp"

namespace odeval::test {

inline std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const std::size_t at = text.find(what);
  CHECK(at != std::string::npos);
  return at == std::string::npos ? text : text.replace(at, what.size(), with);
}

inline Scenario read(const std::string& text, const std::vector<Override>& overrides = {}) {
  return ScenarioFile("x.toml", text).read(overrides, {});
}

inline void refused(const std::string& text, const std::string& message) {
  CHECK_THROWS(read(text), UserError, "x.toml: " + message);
}

}  // namespace odeval::test
