#include "catalogue/versions.hpp"

#include <sys/utsname.h>

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

NamedTexts machine() {
  utsname system{};
  uname(&system);
  return {{"processor", entry("/proc/cpuinfo", "model name", ": ")},
          {"cores", std::to_string(std::thread::hardware_concurrency())},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.machine}};
}

}  // namespace odeval::catalogue
