#pragma once
// Foreign text made fit for an error message.
#include <string>
#include <string_view>

namespace odeval {

/// The text on one line, runs of blanks and control characters as one blank, cut to about `longest` bytes.
inline std::string one_line(std::string_view text, std::size_t longest = 120) {
  std::string line;
  for (const char letter : text) {
    const auto code = static_cast<unsigned char>(letter);
    if (code > 32 && code != 127) {
      line += letter;
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
    if (line.size() > longest) {
      // Not in the middle of a UTF-8 letter.
      while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xC0) == 0x80) line.pop_back();
      if (!line.empty()) line.pop_back();
      return line + "...";
    }
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace odeval
