#include <fmt/format.h>

#include <utility>

#include "model/draft.hpp"

namespace odeval {

namespace {

constexpr double softest = 1e3;  // the greatest cfm

void check_spring(const Draft& draft, const std::string& path, const Spring& spring) {
  const double step_s = draft.scenario.step_s;
  if (softness_of(spring, step_s).cfm <= softest) return;
  draft.fail(path, fmt::format("{}", spring.kd_Ns_m),
             fmt::format("must make step * kp + kd at least {:g} N s/m; it is {:g}", 1 / softest,
                         step_s * spring.kp_N_m + spring.kd_Ns_m),
             Draft::Blame::parts);
}

}  // namespace

void check_softness_of_contacts(const Draft& draft) {
  for (std::size_t i = 0; i < draft.said.contacts.size(); ++i) {
    const ContactTable& contact = draft.said.contacts[i];
    const std::string path = fmt::format("contacts.{}", i);
    const toml::table& table = *draft.tree["contacts"][i].as_table();
    const auto fail = [&](const char* key, const std::string& rule) {
      draft.fail(joined(path, key), shown(*table.get(key)), rule);
    };
    for (const char* key : {"erp", "cfm"}) {
      const bool both = table.contains(key) && (table.contains("kp") || table.contains("kd"));
      if (both) fail(key, "says the same as kp and kd; give one pair or the other");
    }
    for (const auto& [key, other] :
         {std::pair{"erp", "cfm"}, std::pair{"cfm", "erp"}, std::pair{"kp", "kd"}, std::pair{"kd", "kp"}}) {
      if (table.contains(key) && !table.contains(other)) fail(key, fmt::format("needs {} beside it", other));
    }
    if (!contact.spring) continue;
    if (table.contains("restitution")) {
      fail("restitution", "has no effect beside kp and kd, which make what a bounce gives back; remove it");
    }
    check_spring(draft, joined(path, "kd"), *contact.spring);
  }
}

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
  check_spring(draft, "ode.kd", *draft.scenario.ode.spring);
}

}  // namespace odeval
