#pragma once
// Numbers in messages of what may be given.
#include <array>
#include <charconv>
#include <string>

namespace odeval {

/// A limit as one writes it by hand, in the fewest letters: "1e15" and not 1000000000000000, "1e-06", "0.001", "89".
inline std::string limit_text(double number) {
  std::array<char, 32> letters{};
  const auto end = std::to_chars(letters.begin(), letters.end(), number);
  std::string text(letters.data(), end.ptr);
  if (const std::size_t exponent = text.find("e+"); exponent != text.npos) {
    const std::size_t digits = text.find_first_not_of('0', exponent + 2);
    text.erase(exponent + 1, digits - exponent - 1);
  }
  return text;
}

}  // namespace odeval
