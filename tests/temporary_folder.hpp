#pragma once
// A folder for the files of one test, gone when the test ends.
#include <cstdlib>
#include <filesystem>
#include <string>

namespace odeval::test {

class TemporaryFolder {
 public:
  /// Below the folder for temporary files, under a name that no other process has. Ends the program when there is none.
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "odeval-test-XXXXXX").string();  // mkdtemp's letters
    if (mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace odeval::test
