#pragma once
// The answer of an audit as one page that needs nothing but itself.
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "odeval/audit.hpp"
#include "report/document.hpp"
#include "report/page.hpp"

namespace odeval::report {

struct AuditPageParts {
  /// Sections of their own, behind the errors. They are asked for when everything else is drawn; empty: there are none.
  std::function<std::vector<Section>()> pictures;
  std::string command;  // that made it
  std::vector<std::pair<std::string, std::string>> environment;
};

Page audit_page(const audit::Answer& answer, const AuditPageParts& parts);

}  // namespace odeval::report
