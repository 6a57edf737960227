#pragma once
// Text as a cell of a CSV file.
#include <string>
#include <string_view>

namespace odeval {

/// On one line, and quoted where a comma, a quote or a line break would break the row.
inline std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"') quoted += '"';
    quoted += letter == '\n' || letter == '\r' ? ' ' : letter;
  }
  return quoted + '"';
}

}  // namespace odeval
