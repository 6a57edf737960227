#include "catalogue/versions.hpp"

#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "engines/ode/module.hpp"
#include "reference/boost_version.hpp"
#include "reference/cvode_solver.hpp"
#include "sources_digest.hpp"

namespace odeval::catalogue {
namespace {

std::string described(const engine_ode::Module& module) {
  return std::string(module.version) + " " + module.precision + " (" + module.package + "; " + module.configuration +
         ")";
}

/// What stands after `before` in the line of a file of the system that starts with `key`.
std::string entry(const char* file, const std::string& key, const std::string& before) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(key)) return line.substr(line.find(before) + before.size());
  }
  return "unknown";
}

/// Its C library computes the sines of every method.
std::string release() {
  std::string name = entry("/etc/os-release", "PRETTY_NAME", "=");
  std::erase(name, '"');
  return name;
}

}  // namespace

NamedTexts versions() {
#ifdef ODEVAL_HAVE_ODE_SINGLE
  const std::string single = described(engine_ode::odeval_ode_single());
#else
  const std::string single = "not in this build";
#endif
  return {{"odeval", ODEVAL_VERSION},
          {"sources", ODEVAL_SOURCES},
          {"ode_double", described(engine_ode::odeval_ode_double())},
          {"ode_single", single},
          {"sundials", reference::CvodeSolver::version()},
          {"boost", reference::boost_version},
          {"libraries", ODEVAL_LIBRARIES},
          {"compiler", ODEVAL_COMPILER},
          {"flags", ODEVAL_FLAGS},
          {"release", release()}};
}

NamedTexts engine_versions(std::span<const Method* const> asked) {
  Scenario any;  // which all do
  any.duration_s = any.step_s;
  any.mechanism.bodies = {{.shape = Box{{1, 1, 1}}, .mass_kg = 1}};
  NamedTexts found;
  for (const Method* const method : asked) {
    if (!method->tells || method->make == nullptr) continue;
    const std::string engine(method->name.substr(0, method->name.find('-')));
    if (std::ranges::find(found, engine, [](const auto& one) { return one.first; }) != found.end()) continue;
    const Told told = method->make(any, sample_grid(any))->told();
    found.emplace_back(engine, std::get<std::string>(told.front().second));
  }
  return found;
}

NamedTexts engine_versions() {
  std::vector<const Method*> all;
  for (const Method& method : methods()) all.push_back(&method);
  return engine_versions(all);
}

NamedTexts machine() {
  utsname system{};
  uname(&system);
  return {{"processor", entry("/proc/cpuinfo", "model name", ": ")},
          {"cores", std::to_string(std::thread::hardware_concurrency())},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.machine}};
}

}  // namespace odeval::catalogue
