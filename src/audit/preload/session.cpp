#include "audit/preload/session.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>
#include <unordered_map>

#include "audit/preload/clock.hpp"
#include "audit/preload/environment.hpp"
#include "audit/preload/own.hpp"
#include "audit/preload/softness.hpp"

namespace odeval::audit {
namespace {

struct Thread {
  ~Thread();
};
std::atomic<const Thread*> stepping = nullptr;  // and colliding
thread_local const Thread this_thread{};
Thread::~Thread() {
  const Thread* self = this;
  stepping.compare_exchange_strong(self, nullptr);  // another may go on where this one ends
}

void take_message(int, const char* text, std::va_list values) { Session::get().message(text, values); }
void take_last_words(int, const char* text, std::va_list values) { Session::get().last_words(text, values); }

void take_down(char* place, std::size_t size, const char* text, std::va_list values) {
  std::va_list copy;
  va_copy(copy, values);
  std::vsnprintf(place, size, text, copy);
  va_end(copy);
}

/// In any direction, another for each body.
void move(const Body& body, double distance) {
  const double turn = 2.4 * body.number;  // the golden angle: no two bodies go the same way
  const double height = std::sin(1.7 * body.number + 0.6);
  const double across = std::sqrt(1 - height * height);
  const dReal* place = dBodyGetPosition(body.id);
  dBodySetPosition(body.id, place[0] + distance * across * std::cos(turn),
                   place[1] + distance * across * std::sin(turn), place[2] + distance * height);
}

/// A joint's feedback after a step is the mean over its parts. A contact is another in each part, and the program may
/// have ODE tell of it where it tells of no other, or where it tells of all that two bodies had: so each place gets the
/// mean of what was told there, whichever of the contacts that have it ODE told of last, and what is told in all of
/// them is the impulse of the step, over its length. A place is written only right after ODE has: later it may be gone.
class Feedback {
 public:
  Feedback(World& world, int parts) : world_(world), weight_(dReal(1) / parts) {
    for (Joint& joint : world_.joints) joint.feedback = {};
  }
  void add() {
    for (Joint& joint : world_.joints) {
      if (const dJointFeedback* now = dJointGetFeedback(joint.id)) {
        add(joint.feedback.f1, joint.feedback.t1, now->f1, now->t1);
        add(joint.feedback.f2, joint.feedback.t2, now->f2, now->t2);
      }
    }
    told_.clear();
    for (const Made& contact : world_.made) find_told(contact);
    for (const auto& [place, of_second] : told_) add(*place, of_second);
  }
  void hand_over() const {
    for (const Joint& joint : world_.joints) {
      if (dJointFeedback* its = dJointGetFeedback(joint.id)) *its = joint.feedback;
    }
  }

 private:
  /// What ODE tells of: nothing where both bodies are at rest, and of a second body where there is one.
  void find_told(const Made& contact) {
    dJointFeedback* const place = dJointGetFeedback(contact.id);
    if (place == nullptr) return;
    dBodyID first = dJointGetBody(contact.id, 0);
    dBodyID second = dJointGetBody(contact.id, 1);
    const auto is_told = [](dBodyID body) { return body != nullptr && dBodyIsEnabled(body) != 0; };
    if (!is_told(first) && !is_told(second)) return;
    told_[place] |= first != nullptr && second != nullptr;
  }
  void add(dJointFeedback& now, bool of_second) {
    dJointFeedback& mean = of_contacts_[&now];
    add(mean.f1, mean.t1, now.f1, now.t1);
    std::copy_n(mean.f1, 3, now.f1);
    std::copy_n(mean.t1, 3, now.t1);
    if (!of_second) return;
    add(mean.f2, mean.t2, now.f2, now.t2);
    std::copy_n(mean.f2, 3, now.f2);
    std::copy_n(mean.t2, 3, now.t2);
  }
  void add(dReal* force, dReal* torque, const dReal* more_force, const dReal* more_torque) const {
    for (int i = 0; i < 3; ++i) {
      force[i] += weight_ * more_force[i];
      torque[i] += weight_ * more_torque[i];
    }
  }

  World& world_;
  dReal weight_;
  std::unordered_map<const dJointFeedback*, dJointFeedback> of_contacts_;  // by where it is told
  std::unordered_map<dJointFeedback*, bool> told_;                         // in this part; of a second body as well
};

}  // namespace

void* behind(const char* name) {
  void* found = ::dlsym(RTLD_NEXT, name);
  if (found == nullptr) std::abort();  // the library is linked to ODE
  return found;
}

/// Whose clock is not simulated.
void* libc() {
  void* found = ::dlopen("libc.so.6", RTLD_LAZY | RTLD_NOLOAD);
  return found == nullptr ? RTLD_DEFAULT : found;
}

double steady_s() {
  timespec now{};
  static const auto real = reinterpret_cast<decltype(&::clock_gettime)>(::dlsym(libc(), "clock_gettime"));
  real(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Never destroyed: the program's own destructors may call ODE after ours would have run.
Session& Session::get() {
  static Session* const session = new Session;
  return *session;
}

Session::Session()
    : settings_(read_settings()),
      follows_(dCheckConfiguration("ODE_double_precision") != 0),
      record_(settings_.record, settings_.most_bytes),
      overrides_(settings_.set),
      sampler_(settings_.motions, settings_.ledger) {
  if (!follows_) {
    record_.remark(single_precision);
    return;
  }
  if (settings_.ledger) {
    ledger_.emplace(settings_.record);
    worlds_.follow_touches();
  }
  if (settings_.refinement > 1) worlds_.follow_made();
  ::pthread_atfork(nullptr, nullptr, [] { get().leave_to_parent(); });
  ODEVAL_OWN(dSetMessageHandler)(take_message);
  ODEVAL_OWN(dSetDebugHandler)(take_last_words);
}

void Session::message(const char* text, std::va_list values) {
  ++messages_;
  Head* head = record_.head();
  if (head != nullptr && std::atomic_ref(head->messages).fetch_add(1) == 0)
    take_down(head->first_message, sizeof head->first_message, text, values);
  if (program_message != nullptr) program_message(0, text, values);
}

void Session::last_words(const char* text, std::va_list values) {
  if (Head* head = record_.head()) take_down(head->last_words, sizeof head->last_words, text, values);
  if (program_debug != nullptr) return program_debug(0, text, values);
  std::vfprintf(stderr, text, values);
  std::fputc('\n', stderr);
}

void Session::name(dBodyID body, const char* name) {
  for (const Body& one : worlds_.of(dBodyGetWorld(body)).bodies) {
    if (one.id == body) record_.name("body", one.number, name);
  }
}

void Session::name(dJointID joint, const char* name) {
  if (const Joint* its = worlds_.find(joint)) record_.name("joint", its->number, name);
}

void Session::give_samples(dBodyID body) const {
  const auto count = static_cast<unsigned>(dWorldGetAutoDisableAverageSamplesCount(dBodyGetWorld(body)));
  if (samples(count) != count) ODEVAL_OWN(dBodySetAutoDisableAverageSamplesCount)(body, samples(count));
}

const dContact& Session::softened(dWorldID world, const dContact& contact, dContact& place) const {
  if (settings_.refinement == 1 || !settings_.hold_springs) return contact;
  place = contact;
  soften(place.surface, {dWorldGetERP(world), dWorldGetCFM(world)}, settings_.refinement);
  return place;
}

void Session::require_thread() {
  const Thread* its = stepping.load();
  if (its != nullptr && its != &this_thread) end(several_threads);
}

void Session::take_thread() {
  const std::lock_guard guard(lock_);
  require_thread();
  stepping = &this_thread;
}

void Session::end(Remark why) {
  record_.remark(why);
  ::_exit(0);
}

void Session::describe(const World& world) {
  Head* head = record_.head();
  if (head == nullptr || first_world_) return;
  first_world_ = world.number;
  head->remarks |= remarks_;
  head->refinement = static_cast<std::uint32_t>(settings_.refinement);
  dVector3 gravity;
  dWorldGetGravity(world.id, gravity);
  std::copy_n(gravity, 3, head->gravity);
  head->erp = dWorldGetERP(world.id);
  head->cfm = dWorldGetCFM(world.id);
  head->w = dWorldGetQuickStepW(world.id);
  head->iterations = static_cast<std::uint32_t>(dWorldGetQuickStepNumIterations(world.id));
}

int Session::accurately(dWorldID id, dReal h) {
  using Step = int (*)(dWorldID, const dBodyID*, std::size_t, double, char*, std::size_t);
  static const auto step = [] {
    const char* file = std::getenv(environment::accurate);
    void* library = file == nullptr ? nullptr : ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
    return reinterpret_cast<Step>(library == nullptr ? nullptr : ::dlsym(library, "odeval_accurate_step_of"));
  }();
  Session& session = get();
  const World& world = session.worlds_.of(id);
  std::vector<dBodyID> bodies;
  for (const Body& body : world.bodies) bodies.push_back(body.id);
  char why[sizeof(Head::last_words)] = "contacts are made by the program's own callback";
  if (world.contacts == 0 && step != nullptr && step(id, bodies.data(), bodies.size(), h, why, sizeof why) != 0) {
    for (dBodyID body : bodies) {
      if (dBodyIsEnabled(body) != 0) session.moved(body);
    }
    return 1;
  }
  if (Head* head = session.record_.head()) std::copy(std::begin(why), std::end(why), head->last_words);
  session.end(not_accurately);
}

void Session::first_step(World& world, dReal h, Stepper stepper, bool quick) {
  if (settings_.move_m != 0) {
    for (const Body& body : world.bodies) move(body, settings_.move_m);
  }
  {
    const MovedCallbacks::Held held(moved_callbacks_);  // what a start is made by is no step of the program
    overrides_.begin(world, h, stepper);
  }
  if (ledger_ && world.number == first_world_) {
    collisions_.each_space([this](dSpaceID space) { ledger_->draw_space(space); });
  }
  const auto& frame = sampler_.take(world, {.quick = quick});
  record_.add(frame.data(), frame.size(), world.steps, world.t);
}

int Session::step(dWorldID id, dReal h, Stepper stepper, bool quick, const void* frame_of_step) {
  if (!follows_) return stepper(id, h);
  take_thread();
  World& world = worlds_.of(id);
  if (world.steps == 0) describe(world);
  stepper = overrides_.chosen(stepper);
  overrides_.apply(world);
  if (world.steps == 0) first_step(world, h, stepper, quick);
  const int result = settings_.refinement > 1 ? parts(world, h, stepper, frame_of_step) : whole(world, h, stepper);
  if (result == 0) record_.remark(steps_in_vain);
  const std::uint32_t messages = messages_;
  if (record_.head() != nullptr) {
    const double ode_s = ode_s_ + collide_s_;
    const auto& frame = sampler_.take(world, {.h = h, .quick = quick, .messages = messages, .ode_s = ode_s});
    record_.add(frame.data(), frame.size(), world.steps, world.t);
  }
  messages_ -= messages;
  collide_s_ = 0;
  constexpr std::uint64_t of = 7;  // steps one is timed: the clock takes as long as a body's sample
  timed_ = settings_.timed && ++steps_ % of == 0;
  world.contacts = 0;
  world.depth = 0;
  collisions_.clear();
  worlds_.age();
  if (&odeval_simulated_s != nullptr) odeval_simulated_s = std::max(odeval_simulated_s.load(), world.t);
  if (&odeval_clock_asked != nullptr && odeval_clock_asked) record_.remark(asked_the_clock);
  constexpr double rounding = 1e-9;  // of the sum of a million steps
  if (settings_.until_s > 0 && world.t >= settings_.until_s * (1 - rounding)) end(reached_until);
  return result;
}

int Session::whole(World& world, dReal h, Stepper stepper) {
  std::optional<Ledger::Step> step;
  if (ledger_ && record_.head() != nullptr) {
    ledger_->draw(world);
    world.work.program += energy_of(world).sum() - world.energy;
    watch_damped(world);
    step.emplace(*ledger_, world);
  }
  accounts_ = step.has_value();
  const double begun_s = now_s();
  const int result = stepper(world.id, h);
  ode_s_ = now_s() - begun_s;
  accounts_ = false;
  ++world.steps;
  world.t += h;
  if (step) {
    step->taken(h);
    ledger_->add_work(*record_.head());
  }
  if (ledger_ && ledger_->overflowed()) record_.remark(too_many_parts);
  return result;
}

/// What damping takes is told from the velocities before it: from those after it can not be told whether they were
/// above its threshold.
void Session::watch_damped(const World& world) {
  for (const Body& body : world.bodies) {
    const bool is_damped = dBodyGetLinearDamping(body.id) != 0 || dBodyGetAngularDamping(body.id) != 0;
    if (is_damped && moved_callbacks_.watch(body.id)) ODEVAL_OWN(dBodySetMovedCallback)(body.id, take_moved);
  }
}

int Session::parts(World& world, dReal h, Stepper stepper, const void* frame_of_step) {
  const int k = settings_.refinement;
  world.keep_forces();
  Feedback feedback(world, k);
  std::optional<Softened> softened;
  MovedCallbacks::Held held(moved_callbacks_);
  int result = 1;
  for (int part = 0; part < k; ++part) {
    if (part > 0) {
      if (empty_contacts(world, frame_of_step)) {
        softened.reset();  // what the program's callback reads is its own
        renew_contacts(world);
      }
      world.put_forces_back();
    }
    if (settings_.hold_springs && !softened) softened.emplace(world, k);
    if (part == k - 1) held.release();
    result = stepper(world.id, h / k) != 0 ? result : 0;
    feedback.add();
    if (part == 0) own_seed_ = dRandGetSeed();
  }
  feedback.hand_over();
  softened.reset();
  tell_others(world);
  dRandSetSeed(*own_seed_);  // what the program draws next is what it would have drawn
  own_seed_.reset();
  ++world.steps;
  world.t += h;
  return result;
}

void take_moved(dBodyID body) { Session::get().moved(body); }

void Session::moved(dBodyID body) {
  if (MovedCallbacks::Row* row = moved_callbacks_.moved(body)) tell(body, *row);
}

void Session::tell(dBodyID id, MovedCallbacks::Row& row) {
  const MovedCallbacks::Callback callback = row.callback;
  World& world = worlds_.of(dBodyGetWorld(id));
  Body* body = world.find(id, row.place);
  if (body == nullptr) return callback != nullptr ? callback(id) : void();
  if (accounts_) body->keep_found();
  if (callback != nullptr) {
    std::size_t place = row.place;  // the callback may take itself away
    const double before = accounts_ ? energy_of(world, *body).sum() : 0;
    if (world.softened != nullptr) world.softened->give_own_numbers(*body);
    call(callback, id);
    body = world.find(id, place);  // it may have made others
    if (body == nullptr) return;
    if (world.softened != nullptr) world.softened->take_own_numbers(*body);
    const std::lock_guard guard(lock_);
    if (accounts_) world.work.program += energy_of(world, *body).sum() - before;
  }
  if (accounts_) body->keep_left();
}

void Session::call(MovedCallbacks::Callback callback, dBodyID body) {
  const unsigned long of_part = dRandGetSeed();
  if (own_seed_) dRandSetSeed(*own_seed_);
  callback(body);
  if (!own_seed_) return;
  own_seed_ = dRandGetSeed();
  dRandSetSeed(of_part);
}

void Session::tell_others(const World& world) {
  if (moved_callbacks_.empty()) return;
  std::vector<dBodyID> bodies;
  for (const Body& body : world.bodies) bodies.push_back(body.id);
  for (dBodyID body : bodies) {
    if (MovedCallbacks::Row* row = moved_callbacks_.due(body)) tell(body, *row);
  }
}

bool Session::empty_contacts(const World& world, const void* frame_of_step) {
  if (!settings_.renew_contacts || (collisions_.empty() && world.contacts == 0)) return false;
  const bool emptied = !collisions_.empty() && collisions_.can_be_repeated(frame_of_step) && worlds_.empty_contacts();
  if (!emptied) record_.remark(contacts_stayed);
  return emptied;
}

void Session::renew_contacts(World& world) {
  ++collide_depth_;
  try {
    collisions_.repeat(world.id, worlds_.size() == 1);
  } catch (...) {
    --collide_depth_;
    throw;
  }
  --collide_depth_;
}

}  // namespace odeval::audit
