#include "audit/preload/settings.hpp"

#include <cstdlib>

#include "audit/preload/environment.hpp"

namespace odeval::audit {
namespace {

std::string word(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

double number(const char* name, double otherwise) {
  const std::string text = word(name);
  return text.empty() ? otherwise : std::strtod(text.c_str(), nullptr);
}

}  // namespace

Settings read_settings() {
  Settings settings;
  settings.refinement = static_cast<int>(number(environment::refine, settings.refinement));
  settings.hold_springs = word(environment::hold) != "numbers";
  settings.renew_contacts = word(environment::contacts) != "held";
  settings.until_s = number(environment::until, settings.until_s);
  settings.set = word(environment::set);
  settings.move_m = number(environment::move, settings.move_m);
  settings.record = word(environment::record);
  settings.ledger = word(environment::ledger) == "1" && settings.refinement == 1 && !settings.record.empty();
  settings.motions = settings.ledger || word(environment::motions) == "1";
  settings.timed = word(environment::timed) == "1";
  settings.most_bytes = number(environment::most_bytes, settings.most_bytes);
  return settings;
}

}  // namespace odeval::audit
