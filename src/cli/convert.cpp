// odeval convert: a robot's file as a scenario file.
#include <iostream>

#include "cli/commands.hpp"
#include "cli/flags.hpp"
#include "cli/robots.hpp"
#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"
#include "output/file.hpp"

namespace odeval::cli {
namespace {

struct Options {
  std::string file;
  std::string out;
  RobotFlags robot;
};

int convert(const Options& options) {
  if (!is_robot_file(options.file)) {
    throw UserError(one_line(options.file) + ": is no robot's file; one that ends in .urdf or .sdf is wanted");
  }
  if (!options.out.empty() && !options.out.ends_with(".toml")) {
    throw UserError("--out " + one_line(options.out) + ": must end in .toml, as scenario files do");
  }
  const ProvedRobot robot = proved_robot(options.file, options.robot.options(options.file)).value();
  if (options.out.empty()) {
    std::cout << robot.imported.toml;
    return 0;
  }
  write_whole(options.out, robot.imported.toml);
  std::cout << robot.report() << "\nwrote " << options.out << '\n';
  return 0;
}

}  // namespace

Action attach_convert(Flags& flags) {
  const auto options = std::make_shared<Options>();
  flags.add_option("FILE", options->file, "a .urdf or .sdf file").required();
  flags.add_option("--out", options->out, "the scenario file; default: standard output").type_name("FILE.toml");
  options->robot.attach(flags);
  return [options] { return convert(*options); };
}

}  // namespace odeval::cli
