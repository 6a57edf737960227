#include <fmt/format.h>

#include <utility>

#include "model/draft.hpp"

namespace odeval {

void choose_softness(Draft& draft) {
  const auto given = [&](const char* key) { return static_cast<bool>(draft.tree.at_path(key)); };
  const auto typed_key = [&](const char* one, const char* other) {
    const auto typed_one = [&](const char* key) { return given(key) && draft.setting_of(key) != nullptr; };
    return typed_one(one) ? one : typed_one(other) ? other : nullptr;
  };
  if (!given("ode.kp") && !given("ode.kd")) return;
  for (const auto& [key, other] : {std::pair{"ode.kp", "ode.kd"}, std::pair{"ode.kd", "ode.kp"}}) {
    if (!given(key))
      draft.fail(other, shown(*draft.tree.at_path(other).node()), fmt::format("needs {} beside it", key));
  }
  const char* const soft = typed_key("ode.erp", "ode.cfm");
  const bool spring = typed_key("ode.kp", "ode.kd") != nullptr;
  if (soft != nullptr && !spring) {
    for (const char* other : {"ode.erp", "ode.cfm"}) {
      if (!given(other)) {
        draft.fail(soft, "", fmt::format("needs {} beside it, to replace the file's ode.kp and ode.kd", other));
      }
    }
    draft.scenario.ode.spring.reset();
    return;
  }
  const char* const both = given("ode.erp") ? "ode.erp" : given("ode.cfm") ? "ode.cfm" : nullptr;
  if (both != nullptr && (soft != nullptr || !spring)) {
    draft.fail(soft != nullptr ? soft : both, shown(*draft.tree.at_path(both).node()),
               "says the same as ode.kp and ode.kd; give one pair or the other");
  }
  constexpr double softest = 1e3;  // the greatest ode.cfm
  const double cfm = draft.scenario.ode.softness(draft.scenario.step_s).cfm;
  if (!(cfm <= softest)) {
    draft.fail("ode.kd", fmt::format("{}", draft.scenario.ode.spring->kd_Ns_m),
               fmt::format("must make step * kp + kd at least {:g} N s/m; it is {:g}", 1 / softest, 1 / cfm),
               Draft::Blame::parts);
  }
}

}  // namespace odeval
