#pragma once
// Pictures of an audited program: this run, and its limit as an outline over it.
#include <string>
#include <vector>

#include "audit/judge.hpp"
#include "odeval/audit.hpp"
#include "report/document.hpp"

namespace odeval::cli {

/// The moment at which the error grew last, as a section of the page; none where it shows nothing. Throws MachineError
/// as the studio does.
std::vector<report::Section> worst_moment(const audit::Answer& answer, const audit::Records& records);

/// The bytes of an animated PNG, at real-time speed, for as long as the motion is not lost; empty where no run moves.
std::string audit_film(const audit::Answer& answer, const audit::Records& records);

}  // namespace odeval::cli
