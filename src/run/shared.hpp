#pragma once
#include <functional>
#include <string_view>

#include "odeval/error.hpp"

namespace odeval::run {

/// Bytes that outlive the process that wrote them and that all processes see which were forked since. Throws
/// SharedError.
class Shared {
 public:
  Shared();
  ~Shared();
  Shared(const Shared&) = delete;
  Shared& operator=(const Shared&) = delete;

  void fill(std::string_view bytes) const;
  void clear() const;

  /// Calls `use` with the bytes, which are gone afterwards.
  void with(const std::function<void(std::string_view bytes)>& use) const;

 private:
  int descriptor_;
};

/// The machine has no memory for it.
class SharedError : public MachineError {
 public:
  using MachineError::MachineError;
};

}  // namespace odeval::run
