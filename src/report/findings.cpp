#include "report/findings.hpp"

#include <stdexcept>

namespace odeval::report {

void Findings::add(const std::string& name, Finding finding) {
  if (!findings_.emplace(name, std::move(finding)).second) {
    throw std::logic_error("two experiments measure '" + name + "'");
  }
}

const Finding* Findings::find(std::string_view name) const {
  const auto found = findings_.find(name);
  return found == findings_.end() ? nullptr : &found->second;
}

}  // namespace odeval::report
