#pragma once
// The calls of dSpaceCollide and dSpaceCollide2 that the program made for its next step, to be made again.
#include <ode/ode.h>

#include <vector>

namespace odeval::audit {

class Collisions {
 public:
  ~Collisions();

  /// `second` is null of dSpaceCollide, and `first` then a space.
  void add(dGeomID first, dGeomID second, void* data, dNearCallback* callback);
  void forget(dGeomID geom);  // which is about to go
  void clear();

  bool empty() const { return calls_.empty() && !too_many_; }
  /// Whether what the program gave to its callback is still there, as far as one can see: nothing of a function that
  /// has returned.
  bool can_be_repeated(const void* frame_of_step) const;
  /// Calls `take` with each space in them.
  template <class Take>
  void each_space(const Take& take) const {
    for (const Call& call : calls_) {
      for (dGeomID geom : {call.first, call.second}) {
        if (geom != nullptr && dGeomIsSpace(geom) != 0) take(reinterpret_cast<dSpaceID>(geom));
      }
    }
  }
  /// Those that meet bodies of this world.
  void repeat(dWorldID world, bool only_world) const;

 private:
  struct Call {
    dGeomID first;
    dGeomID second;
    void* data;
    dNearCallback* callback;
    bool kept;  // of Python
  };
  static void release(const Call& call);

  static constexpr std::size_t most_calls = 1 << 16;  // of a step: a program may collide for ever, and never step

  std::vector<Call> calls_;
  bool too_many_ = false;  // since the last step: none is kept
};

}  // namespace odeval::audit
