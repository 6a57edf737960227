#pragma once
// All that the library knows of the program it is loaded beside.
#include <ode/ode.h>
#include <pthread.h>

#include <atomic>
#include <cstdarg>
#include <mutex>
#include <optional>

#include "audit/preload/collisions.hpp"
#include "audit/preload/ledger.hpp"
#include "audit/preload/moved.hpp"
#include "audit/preload/overrides.hpp"
#include "audit/preload/record.hpp"
#include "audit/preload/sample.hpp"
#include "audit/preload/settings.hpp"
#include "audit/preload/worlds.hpp"

namespace odeval::audit {

double steady_s();

class Session {
 public:
  using Stepper = int (*)(dWorldID, dReal);

  /// The only one, from the first call of ODE on. It does not end before the process.
  static Session& get();

  /// Whether this is an ODE that the library knows.
  bool follows() const { return follows_; }

  /// What the program makes, destroys or names: of one thread at a time until one steps or collides, and from then on
  /// of that one alone. `change` takes the session.
  template <class Change>
  void follow(const Change& change) {
    if (!follows_) return;
    const std::lock_guard guard(lock_);
    require_thread();
    change(*this);
  }
  Worlds& worlds() { return worlds_; }
  Collisions& collisions() { return collisions_; }
  MovedCallbacks& moved_callbacks() { return moved_callbacks_; }

  /// ODE has moved the body, in a step and in whichever thread: calls the program's callback where it is to.
  void moved(dBodyID body);

  /// One step of the program, of the length h that it asked for. Frames of the program's functions that have returned
  /// were below `frame_of_step`.
  int step(dWorldID world, dReal h, Stepper stepper, bool quick, const void* frame_of_step);

  /// A collision detection of the program, which `act` does.
  template <class Act>
  void collide(dGeomID first, dGeomID second, void* data, dNearCallback* callback, const Act& act);

  /// Whether what the program makes now is made in a callback that can be called again.
  bool in_callback() const { return collide_depth_ > 0; }

  /// A contact as the step's part wants it: itself, or what is made of it in `place`.
  const dContact& softened(dWorldID world, const dContact& contact, dContact& place) const;

  dMessageFunction* program_message = nullptr;  // its handlers; null: ODE's own
  dMessageFunction* program_debug = nullptr;
  void message(const char* text, std::va_list values);
  void last_words(const char* text, std::va_list values);

  void name(dBodyID body, const char* name);
  void name(dJointID joint, const char* name);

  /// Samples of the parts in the place of so many of steps, and back. One is no average, and stays.
  unsigned samples(unsigned of_steps) const { return of_steps > 1 ? of_steps * parts_held() : of_steps; }
  int program_samples(int of_parts) const {
    return of_parts > 1 ? of_parts / static_cast<int>(parts_held()) : of_parts;
  }

  /// ODE gives a body the world's, by a call of its own that comes here or does not: so they are given once more.
  void give_samples(dBodyID body) const;

  /// A step by the accurate step, with no bits of ODE's in it. Ends the program where it can not.
  static int accurately(dWorldID world, dReal h);

  /// Joints take the world's ERP and CFM when they are made.
  void set_what_is_tried(dWorldID world) {
    follow([world](Session& its) { its.overrides_.apply(its.worlds_.of(world)); });
  }

  void remark(Remark what) { remarks_ |= what; }

  void leave_to_parent() { record_.leave_to_parent(); }

 private:
  Session();
  /// Parts of a step, where numbers per step are converted; else 1.
  unsigned parts_held() const {
    return follows_ && settings_.hold_springs ? static_cast<unsigned>(settings_.refinement) : 1;
  }
  /// 0 where the step is not timed.
  double now_s() const { return timed_ ? steady_s() : 0; }
  void describe(const World& world);
  void first_step(World& world, dReal h, Stepper stepper, bool quick);
  /// One of ODE's, with a ledger where there is one.
  int whole(World& world, dReal h, Stepper stepper);
  int parts(World& world, dReal h, Stepper stepper, const void* frame_of_step);
  /// Between the parts of a step. False where contacts are not to be made anew, or can not.
  bool empty_contacts(const World& world, const void* frame_of_step);
  void renew_contacts(World& world);
  void watch_damped(const World& world);
  /// Calls the callback, for which the body's numbers are the program's.
  void tell(dBodyID body, MovedCallbacks::Row& row);
  /// And ODE's random numbers.
  void call(MovedCallbacks::Callback callback, dBodyID body);
  /// Bodies that the last part of the step has not moved, and another has.
  void tell_others(const World& world);
  void require_thread();
  /// The calling thread is the one that steps and collides, until it ends. Ends the program where there is another.
  void take_thread();
  [[noreturn]] void end(Remark why);

  Settings settings_;
  std::uint32_t remarks_ = 0;  // of Remark, for when the program takes a step
  bool follows_;
  Record record_;
  std::optional<Ledger> ledger_;
  Overrides overrides_;
  Worlds worlds_;
  Collisions collisions_;
  MovedCallbacks moved_callbacks_;
  Sampler sampler_;
  std::optional<std::uint32_t> first_world_;  // that steps
  int collide_depth_ = 0;
  bool accounts_ = false;                    // for the step that ODE takes
  std::optional<unsigned long> own_seed_;    // of the program, while ODE has that of a part
  std::uint64_t steps_ = 0;                  // of all worlds
  bool timed_ = false;                       // the next step, and the collisions for it
  double collide_s_ = 0;                     // since the last step
  double ode_s_ = 0;                         // of the step
  std::atomic<std::uint32_t> messages_ = 0;  // of any thread
  std::mutex lock_;
};

template <class Act>
void Session::collide(dGeomID first, dGeomID second, void* data, dNearCallback* callback, const Act& act) {
  if (!follows_) return act();
  take_thread();
  // A callback may throw through this, and one of a nested space is called again by the outer one.
  struct Depth {
    Session& session;
    double begun_s;
    explicit Depth(Session& its) : session(its), begun_s(its.now_s()) { ++session.collide_depth_; }
    ~Depth() {
      if (--session.collide_depth_ == 0) session.collide_s_ += session.now_s() - begun_s;
    }
  };
  if (collide_depth_ == 0) collisions_.add(first, second, data, callback);
  const Depth depth(*this);
  act();
}

}  // namespace odeval::audit
