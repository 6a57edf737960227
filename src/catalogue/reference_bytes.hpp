#pragma once
// A reference as bytes, to pass it from one process of this program to another.
#include <string>
#include <string_view>

#include "odeval/reference.hpp"

namespace odeval::catalogue {

std::string reference_bytes(const Reference& reference);

/// Bytes of `reference_bytes` only: they are not checked.
Reference reference_of(std::string_view bytes);

}  // namespace odeval::catalogue
