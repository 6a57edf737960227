#pragma once
// A line of a comma-separated file, read without the project's own reader.
#include <string>
#include <vector>

namespace odeval::test {

/// Its cells as they stand; none holds a comma.
inline std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> parts(1);
  for (const char letter : line) {
    if (letter == ',') {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  return parts;
}

}  // namespace odeval::test
