#include "cli/robots.hpp"

#include <iostream>

#include "catalogue/import_proof.hpp"
#include "cli/settings.hpp"
#include "model/one_line.hpp"
#include "model/robot_reader.hpp"
#include "odeval/error.hpp"
#include "output/import_report.hpp"

namespace odeval::cli {

void RobotFlags::attach(Flags& flags) {
  base_flag_ = flags.add_option("--base", base_, "of a URDF file: its root link stands fixed in the world, or flies")
                   .one_of({"fixed", "free"})
                   .capture_default_str()
                   .group("Robots' files");
  meshes_flag_ = flags.add_option("--meshes", meshes_, "of a robot's file: a mesh is the box around it, or is refused")
                     .one_of({"box", "refuse"})
                     .capture_default_str()
                     .group("Robots' files");
}

ImportOptions RobotFlags::options(const std::filesystem::path& file) const {
  for (const auto& [flag, name] : {std::pair{&base_flag_, "--base "}, std::pair{&meshes_flag_, "--meshes "}}) {
    if (!*flag || !(*flag)->given() || is_robot_file(file)) continue;
    throw UserError(name + (flag == &base_flag_ ? base_ : meshes_) + ": is for robots' files, .urdf or .sdf; " +
                    one_line(file.string()) + " is none");
  }
  return {.base_free = base_ == "free", .refuse_meshes = meshes_ == "refuse"};
}

std::string ProvedRobot::report() const { return import_report(imported.robot, bodies, proof); }

std::string ProvedRobot::json(const std::filesystem::path& file) const {
  return import_json(file.string(), imported.robot, bodies, proof);
}

std::optional<ProvedRobot> proved_robot(const std::filesystem::path& file, const ImportOptions& options) {
  if (!is_robot_file(file)) return std::nullopt;
  Imported imported = import_robot(file, options);
  const Scenario scenario = ScenarioFile(file, imported.toml).read({}, known_names());
  const ImportProof proof = catalogue::prove_import(imported, scenario);
  catalogue::require_proved(proof, scenario);
  return ProvedRobot{std::move(imported), scenario.mechanism.bodies.size(), proof};
}

void tell_of_import(const std::filesystem::path& file) {
  if (!is_robot_file(file)) return;
  const std::string name = one_line(file.string());
  std::cerr << "odeval: " << name << ": is read by rules, and not all of it is taken; 'odeval convert " << name
            << "' lists them\n";
}

}  // namespace odeval::cli
