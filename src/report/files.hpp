#pragma once
// The tables of a report as CSV, with all digits.
#include <span>
#include <string>

#include "report/claims.hpp"
#include "report/document.hpp"

namespace odeval::report {

/// A header of the columns and one line a row; a missing cell is empty.
std::string table_csv(const Table& table);

/// name, value, uncertainty, unit, meaning, missing.
std::string findings_csv(const Findings& findings);

/// One line for every condition of every claim: claim, verdict, kind (confirmed_if, refuted_if), finding, relation,
/// bound, value, uncertainty, unit, holds (yes, no, cannot tell, or empty where the value is missing), missing.
std::string verdicts_csv(std::span<const Judged> verdicts, const Findings& findings);

}  // namespace odeval::report
