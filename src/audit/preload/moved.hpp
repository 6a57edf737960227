#pragma once
// The callback that ODE calls of a body in a step once it has moved it (dBodySetMovedCallback): of all that ODE calls
// in a step, what tells the program of the step, and is not what the step is made of.
#include <ode/ode.h>

#include <cstddef>
#include <mutex>
#include <unordered_map>

namespace odeval::audit {

/// It is called once a step of the program, whatever the step is taken in: when the last part has moved the body, or
/// after it where that left the body at rest.
///
/// ODE moves bodies in the threads that the program gave it, each body in one.
class MovedCallbacks {
 public:
  using Callback = void (*)(dBodyID);
  struct Row {
    Callback callback = nullptr;  // null: none, and it is watched
    std::size_t place = 0;        // of the body in its world's, if it still is there
    bool due = false;             // it was moved, and not told
  };

  /// Null: none.
  void set(dBodyID body, Callback callback);
  /// `moved` is to tell of the body, whether or not it has a callback. False where it does already.
  bool watch(dBodyID body);
  void forget(dBodyID body);
  bool empty() const { return of_body_.empty(); }

  /// ODE has moved the body. Null where nothing is to be called now. What is returned stays until `forget`.
  Row* moved(dBodyID body);
  /// Null where the body was not moved, or its callback was called since.
  Row* due(dBodyID body);

  /// While it lives nothing is called, and afterwards nothing is due.
  class Held {
   public:
    explicit Held(MovedCallbacks& callbacks);
    ~Held();
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

    /// From now on what is moved is told.
    void release();

   private:
    MovedCallbacks& callbacks_;
  };

 private:
  std::mutex lock_;
  std::unordered_map<dBodyID, Row> of_body_;
  bool held_ = false;
};

/// What ODE is given in the place of each, and for those that are watched.
void take_moved(dBodyID body);

}  // namespace odeval::audit
