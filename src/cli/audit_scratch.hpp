#pragma once
// Where an audit's runs leave their records.
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

#include "odeval/error.hpp"

namespace odeval::cli {

/// A folder of its own in TMPDIR, gone with it. Throws MachineError where there can be none.
class AuditScratch {
 public:
  AuditScratch() {
    std::error_code error;
    const std::filesystem::path place = std::filesystem::temp_directory_path(error);
    if (error) throw MachineError("TMPDIR: no folder for records: " + error.message());
    std::string name = (place / "odeval-audit-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {  // which fills in the letters
      throw MachineError(name + ": no folder for records: " + std::strerror(errno));
    }
    folder_ = name;
  }
  ~AuditScratch() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  AuditScratch(const AuditScratch&) = delete;
  AuditScratch& operator=(const AuditScratch&) = delete;

  /// Of the run of that number; more files may stand beside it under the same name with an ending.
  std::filesystem::path record(std::size_t run) const { return folder_ / (std::to_string(run) + ".record"); }

 private:
  std::filesystem::path folder_;
};

}  // namespace odeval::cli
