// odeval compare: two result folders: the same bytes, the same within what is known, or different.
#include <iostream>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "output/comparison.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string a;
  std::string b;
  bool quiet = false;
  bool json = false;
};

int compare(const Options& options) {
  const Comparison comparison = compare_folders(options.a, options.b);
  if (options.json) {
    std::cout << comparison_json(comparison);
  } else if (!options.quiet) {
    std::cout << "A  " << options.a << "\nB  " << options.b << "\n\n" << comparison_table(comparison);
  }
  return comparison.different() ? 1 : 0;
}

}  // namespace

Action attach_compare(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("DIR_A", options->a, "a folder of results").required();
  flags.add_option("DIR_B", options->b, "another").required();
  flags.add_flag("--quiet", options->quiet, "print nothing; the exit status tells");
  flags.add_flag("--json", options->json, "print JSON");
  return [options] { return compare(*options); };
}

}  // namespace odeval::cli
