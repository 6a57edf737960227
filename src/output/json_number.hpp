#pragma once
// JSON has no infinity: null would read as "no value", which a broken run must not.
#include <cmath>
#include <nlohmann/json.hpp>

#include "output/number.hpp"

namespace odeval {

/// The number, or the string "inf", "-inf" or "nan".
inline nlohmann::ordered_json json_number(double number) {
  if (std::isfinite(number)) return number;
  return number_text(number);
}

}  // namespace odeval
