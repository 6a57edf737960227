#pragma once
// The report as one page that needs nothing but itself.
#include <string>
#include <vector>

#include "report/claims.hpp"
#include "report/document.hpp"

namespace odeval::report {

struct Page {
  std::string html;                  // well-formed XML too; same input, same bytes
  std::vector<std::string> missing;  // what could not be drawn, and why; the page says it in its place
};

/// `verdicts` in the order they are shown in. Tables link to `report/NAME.csv`. Throws std::logic_error when two
/// tables, figures, pictures or sections share a name.
Page make_page(const Document& document, const std::vector<Judged>& verdicts, const Findings& findings);

/// "report/order.csv": where the page looks for a table's numbers.
std::string csv_of(const Table& table);

}  // namespace odeval::report
