#pragma once
#include "odeval/audit.hpp"

namespace odeval::cli {

/// Names, messages and what else came from the program, made fit to be told: one line of UTF-8 each.
void make_readable(audit::Answer& answer);

}  // namespace odeval::cli
