#pragma once
// The one spelling of a number in files: the shortest text that reads back as the same bits.
#include <fmt/compile.h>

#include <cmath>
#include <string>

namespace odeval {

inline constexpr std::size_t longest_number = 24;  // -2.2250738585072014e-308

/// Writes the number at `out`, which has room for `longest_number` characters, and returns where it ends. No locale;
/// the sign of zero is kept ("-0"); what is not finite becomes "inf", "-inf", "nan".
inline char* put_number(char* out, double number) {
  if (std::isnan(number)) number = std::fabs(number);  // its sign says nothing
  if (number == 0 && !std::signbit(number)) {          // most cells of a planar motion in space
    *out++ = '0';
    return out;
  }
  return fmt::format_to(out, FMT_COMPILE("{}"), number);
}

inline std::string number_text(double number) {
  char text[longest_number];
  return std::string(text, put_number(text, number));
}

}  // namespace odeval
