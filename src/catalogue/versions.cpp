#include "catalogue/versions.hpp"

#include <sys/utsname.h>

#include <fstream>
#include <thread>

#include "engine_ode/module.hpp"
#include "reference/boost_version.hpp"
#include "reference/cvode_solver.hpp"
#include "sources_digest.hpp"

namespace odeval::catalogue {
namespace {

std::string described(const engine_ode::Module& module) {
  return std::string(module.version) + " " + module.precision + " (" + module.configuration + ")";
}

std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  const std::string key = "model name";
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with(key)) return line.substr(line.find(": ") + 2);
  }
  return "unknown";
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
          {"compiler", ODEVAL_COMPILER},
          {"flags", ODEVAL_FLAGS}};
}

NamedTexts machine() {
  utsname system{};
  uname(&system);
  return {{"processor", processor()},
          {"cores", std::to_string(std::thread::hardware_concurrency())},
          {"system", std::string(system.sysname) + " " + system.release + " " + system.machine}};
}

}  // namespace odeval::catalogue
