// A recommendation on its way from one process to another.
#include "catalogue/settings_search.hpp"
#include "output/bytes.hpp"

namespace odeval {

template <class Way, class Value>
requires bytes::is<Value, Change>
void pass(Way& way, Value& change) {
  auto& [key, before, value, steps_without, most_steps_without, cost_without] = change;
  each(way, key, before, value, steps_without, most_steps_without, cost_without);
}

template <class Way, class Value>
requires bytes::is<Value, Reached>
void pass(Way& way, Value& reached) {
  auto& [value, uncertainty] = reached;
  each(way, value, uncertainty);
}

template <class Way, class Value>
requires bytes::is<Value, Nearby>
void pass(Way& way, Value& nearby) {
  auto& [tried, worst, share] = nearby;
  each(way, tried, worst, share);
}

template <class Way, class Value>
requires bytes::is<Value, Effort>
void pass(Way& way, Value& effort) {
  auto& [steps, most_steps, settings, cut, untried] = effort;
  each(way, steps, most_steps, settings, cut, untried);
}

template <class Way, class Value>
requires bytes::is<Value, Recommended>
void pass(Way& way, Value& run) {
  auto& [method, kind, place, changes, knob, before, setting, reached, steps, why_not, cpu_per_s, cpu_spread, command,
         nearby, effort] = run;
  each(way, method, kind, place, changes, knob, before, setting, reached, steps, why_not, cpu_per_s, cpu_spread,
       command, nearby, effort);
}

namespace catalogue {

std::string packed(const Recommended& run) { return bytes::of(run); }
Recommended unpacked(std::string_view bytes) { return odeval::bytes::read<Recommended>(bytes); }

}  // namespace catalogue
}  // namespace odeval
