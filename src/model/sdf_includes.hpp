#pragma once
// Models of other files in an SDFormat file.
#include <filesystem>
#include <string>
#include <string_view>

namespace odeval {

/// The text with the model in the place of each <include>, under the name and pose that this gives it; without one as
/// it is. A uri names a file or a model's folder (its model.sdf), with model:// or without, below the file's folder or
/// the one above. Throws UserError, naming the file and the uri, when there is none, when it includes itself, or
/// when its version of SDFormat tells axes of joints otherwise than that of the file.
std::string with_includes(const std::filesystem::path& file, std::string_view text);

}  // namespace odeval
