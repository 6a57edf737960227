#pragma once
// Numbers and text as the page shows them.
#include <string>
#include <string_view>

#include "report/findings.hpp"

namespace odeval::report {

/// Three significant digits: "0.00888", "5.37e-5"; whole numbers below ten million in full, and a number that has fewer
/// digits without zeros at its end. The number is finite.
std::string shown(double number);

/// "0.00888 ± 3e-10 rad", "0.98 (0.97 to 0.99)" where the uncertainty is not the reference's. The finding has a finite
/// value.
std::string shown(const Finding& finding);

/// The same without its uncertainty where that is below what three digits show.
std::string shown_plainly(const Finding& finding);

/// Text as markup shows it: & < > and quotes.
std::string escaped(std::string_view text);

std::string base64(std::string_view bytes);

}  // namespace odeval::report
