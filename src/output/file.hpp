#pragma once
// Files that appear under their name only when they are whole, and files read whole.
#include <filesystem>
#include <string>
#include <string_view>

namespace odeval {

/// Makes a folder and those on the way, or leaves them as they are. Throws MachineError, which names the folder and the
/// cause.
void make_folder(const std::filesystem::path& folder);

/// Creates the folders on the way, writes to a temporary name beside the file and renames it.
/// A name that already belongs to something else than a file (a device, a pipe) is written to directly.
/// Throws MachineError, which names the file and the cause; no temporary file stays behind.
void write_whole(const std::filesystem::path& file, std::string_view text);

/// The same for a text that comes piece by piece.
class WholeFile {
 public:
  explicit WholeFile(std::filesystem::path file);
  ~WholeFile();  // without `finish` nothing was written
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;

  void write(std::string_view text);
  void finish();

 private:
  [[noreturn]] void give_up(int cause);
  void flush();

  std::filesystem::path file_;     // as it was asked for
  std::filesystem::path target_;   // where a link leads
  std::filesystem::path written_;  // its temporary name, or the target where that is no file
  int descriptor_ = -1;
  std::string buffer_;
};

/// Throws UserError, which names the file and the cause, when it cannot be read.
std::string read_whole(const std::filesystem::path& file);

}  // namespace odeval
