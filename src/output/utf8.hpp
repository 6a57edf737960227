#pragma once
#include <string>

namespace odeval {

/// The text, with U+FFFD where it is no UTF-8.
std::string utf8(const std::string& text);

}  // namespace odeval
