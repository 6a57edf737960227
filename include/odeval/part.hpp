#pragma once
// Parts of the program that are files of their own: modules that are loaded when they are wanted, libraries for others.
#include <dlfcn.h>

#include <filesystem>
#include <string>

#include "odeval/error.hpp"

namespace odeval {

/// The part's file: beside the installed program, wherever that was moved to, or in the build tree.
/// `installed` is its place below the prefix ("lib/odeval/libodeval_painter.so"), `built` the whole path in the build.
inline std::string part_file(const char* installed, const char* built) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  const fs::path beside = program.parent_path().parent_path() / installed;
  return fs::is_regular_file(beside, ignored) ? beside.string() : built;
}

/// A function of a module, which is loaded and stays loaded: what it makes is its own code. Function: the type of a
/// pointer to it. Throws MachineError, which begins with `what` is wanted of it ("pictures") and names the cause.
template <class Function>
Function part_function(const std::string& file, const char* name, const char* what) {
  void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const found = module == nullptr ? nullptr : dlsym(module, name);
  if (found == nullptr) throw MachineError(std::string(what) + ": " + dlerror());
  // OpenBLAS, which a module may bring, hands matrices of ten rows to all cores: beside other jobs that waits twenty
  // times as long as it works, and sums hang on the number of cores.
  using SetThreads = void (*)(int);
  const auto set_threads = reinterpret_cast<SetThreads>(dlsym(module, "openblas_set_num_threads"));
  if (set_threads != nullptr) set_threads(1);
  return reinterpret_cast<Function>(found);
}

}  // namespace odeval
