#pragma once
// The page as `odeval report` makes it.
#include <functional>
#include <string>

#include "report/document.hpp"
#include "report/findings.hpp"

namespace odeval::cli {

struct ReportOptions {
  std::string out = "results";
  std::string releases{};  // a folder of results of another release of ODE, or empty
  bool check = false;      // the scenarios' tolerances as well, whose exit status it is then
  bool quiet = false;
};

/// Runs everything, writes the page and what it links to, and returns the exit status. `seen` is shown what the page is
/// made of, before its first file.
using SeePage = std::function<void(const report::Document&, const report::Findings&)>;
int report(const ReportOptions& options, const SeePage& seen = {});

}  // namespace odeval::cli
