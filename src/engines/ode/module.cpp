#include "engines/ode/module.hpp"

#include <dlfcn.h>
#include <ode/ode.h>
#include <ode/version.h>

#include <filesystem>
#include <string>

#include "engines/ode/library.hpp"
#include "engines/ode/make.hpp"
#include "engines/ode/take_back.hpp"
#include "odeval/error.hpp"

#if defined(dIDESINGLE)
#define ODEVAL_ENTRY odeval_ode_single
#define ODEVAL_PRECISION "single"
#else
#define ODEVAL_ENTRY odeval_ode_double
#define ODEVAL_PRECISION "double"
#endif

namespace odeval::engine_ode {

extern "C" __attribute__((visibility("default"))) const Module& ODEVAL_ENTRY() {
  static const Module module = [] {
    use_library();
    // The token is the library's word, the size the headers': a mix of the two would compute garbage in silence.
    const std::size_t bytes = std::string_view(ODEVAL_PRECISION) == "double" ? sizeof(double) : sizeof(float);
    if (dCheckConfiguration("ODE_" ODEVAL_PRECISION "_precision") == 0 || sizeof(dReal) != bytes) {
      throw MachineError("the ODE library of the " ODEVAL_PRECISION "-precision module is not " ODEVAL_PRECISION
                         " precision: " +
                         std::string(dGetConfiguration()));
    }
#ifdef ODEVAL_ODE_FILE
    // The version is the headers' word. Another library of the same soname can be loaded in the place of theirs.
    Dl_info loaded;
    if (dladdr(dGetConfiguration(), &loaded) == 0) throw MachineError("no file holds the ODE that was loaded");
    const std::filesystem::path file = std::filesystem::canonical(loaded.dli_fname);
    if (file.filename() != ODEVAL_ODE_FILE) {
      throw MachineError("this build is for " ODEVAL_ODE_FILE " of ODE " dODE_VERSION ", and " + file.string() +
                         " was loaded; build it again, or leave LD_LIBRARY_PATH alone");
    }
#endif
    return Module{ODEVAL_PRECISION, dODE_VERSION,    ODEVAL_ODE_PACKAGE, dGetConfiguration(),
                  &make_step,       &make_quickstep, &make_stepped,      &take_back};
  }();
  return module;
}

}  // namespace odeval::engine_ode
