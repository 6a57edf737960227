#pragma once
// What another release of ODE changes: this page's runs beside those of another folder of results, by odeval compare.
#include <filesystem>
#include <optional>

#include "report/document.hpp"

namespace odeval::report {

/// Throws UserError unless `other` holds results of a release of ODE that is not `here`, as summaries name it.
void require_other_release(const std::filesystem::path& other, const std::string& here);

/// Every scenario and method of both folders; without another one how to come to it.
Section releases_section(const std::filesystem::path& own, const std::optional<std::filesystem::path>& other,
                         const std::string& here);

}  // namespace odeval::report
