#pragma once
// The raw tree of a scenario file with the command line's values in place; nothing in it is checked yet.
//
// toml++ 3.3 has assertions that malformed files break ("[.[x]]"). Debian's shared library, which pkg-config's flags
// select, is built without them and reports such a file as a syntax error; header-only, a debug build would abort.
#include <toml++/toml.h>
#include <filesystem>
#include <string>
#include <vector>

#include "scenario/override.hpp"

namespace odeval {

/// Throws UserError for a file that cannot be read, a syntax error (with its line), a value that is no TOML
/// and a key that leads nowhere.
toml::table toml_tree(const std::filesystem::path& file, const std::vector<Override>& overrides);

/// The setting as the user typed it: `--erp 1.5`, `--set q0=[1.0]`.
std::string typed(const Override& setting);

}  // namespace odeval
