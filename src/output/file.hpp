#pragma once
// Files that appear under their name only when they are whole, and files read whole.
#include <filesystem>
#include <string>
#include <string_view>

namespace odeval {

/// Creates the folders on the way, writes to a temporary name beside the file and renames it.
/// A name that already belongs to something else than a file (a device, a pipe) is written to directly.
/// Throws MachineError, which names the file and the cause; no temporary file stays behind.
void write_whole(const std::filesystem::path& file, std::string_view text);

/// Throws UserError, which names the file and the cause, when it cannot be read.
std::string read_whole(const std::filesystem::path& file);

}  // namespace odeval
