#pragma once
// Where the program finds its data, in the build tree and when installed.
#include <filesystem>

namespace odeval::catalogue {

/// The folder of the scenario files that come with the program.
std::filesystem::path scenario_folder();

}  // namespace odeval::catalogue
