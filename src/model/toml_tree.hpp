#pragma once
// The raw tree of a scenario file with the command line's values in place; nothing in it is checked yet.
//
// toml++ 3.3 has assertions that malformed files break ("[.[x]]"). Debian's shared library, which pkg-config's flags
// select, is built without them and reports such a file as a syntax error; header-only, a debug build would abort.
#include <toml++/toml.h>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "model/override.hpp"

namespace odeval {

/// The text of a scenario file. Throws UserError when it cannot be read or is no page of text.
std::string scenario_text(const std::filesystem::path& file);

/// Throws UserError, with `file` as its name and the line, for a syntax error.
toml::table toml_tree(const std::filesystem::path& file, std::string_view text);

/// Puts the settings into the tree. Throws UserError for a value that is no TOML and a key that leads nowhere.
void apply(toml::table& tree, const std::vector<Override>& overrides);

}  // namespace odeval
