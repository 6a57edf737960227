#include "output/terminal.hpp"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace odeval {
namespace {

bool on = false;

std::string in(const char* colour, const std::string& text) {
  return on && !text.empty() ? std::string("\033[") + colour + "m" + text + "\033[0m" : text;
}

}  // namespace

bool wants_colours(int descriptor) {
  const char* const no = std::getenv("NO_COLOR");  // set, and not empty
  const char* const terminal = std::getenv("TERM");
  return ::isatty(descriptor) == 1 && (no == nullptr || *no == '\0') && terminal != nullptr &&
         std::string_view(terminal) != "dumb";
}

void colour_tables(bool wanted) { on = wanted; }

std::string bold(const std::string& text) { return in("1", text); }
std::string red(const std::string& text) { return in("31", text); }
std::string green(const std::string& text) { return in("32", text); }

}  // namespace odeval
