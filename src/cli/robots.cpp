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
  const auto add = [&](Choice& choice, const char* other, const char* meaning) {
    choice.flag = flags.add_option(choice.name, choice.value, meaning);
    choice.flag->one_of({choice.value, other}).capture_default_str().group("Robots' files");
  };
  add(base_, "free", "of a URDF file: its root link stands fixed in the world, or flies");
  add(friction_, "drop", "of joints: a motor that keeps a speed of 0, which the reference has to follow, or none");
  add(meshes_, "refuse", "a mesh is the box around it, or is refused");
}

ImportOptions RobotFlags::options(const std::filesystem::path& file) const {
  for (const Choice* choice : {&base_, &friction_, &meshes_}) {
    if (!choice->flag || !choice->flag->given() || is_robot_file(file)) continue;
    throw UserError(choice->name + " " + choice->value + ": is for robots' files, .urdf or .sdf; " +
                    one_line(file.string()) + " is none");
  }
  return {.drop_friction = friction_.value == "drop",
          .base_free = base_.value == "free",
          .refuse_meshes = meshes_.value == "refuse"};
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
