#pragma once
// The answer of an audit as one page that needs nothing but itself.
#include <string>
#include <utility>
#include <vector>

#include "odeval/audit.hpp"
#include "report/document.hpp"
#include "report/page.hpp"

namespace odeval::report {

struct AuditPageParts {
  std::vector<Section> pictures;  // sections of their own, behind the errors
  std::string command;            // that made it
  std::vector<std::pair<std::string, std::string>> environment;
};

Page audit_page(const audit::Answer& answer, const AuditPageParts& parts);

}  // namespace odeval::report
