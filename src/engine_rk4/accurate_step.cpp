#include "engine_rk4/accurate_step.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "engine_rk4/impact.hpp"
#include "engine_rk4/motion.hpp"

namespace odeval {

using namespace engine_rk4;

namespace {

// An impact is located to this overlap, m: a thousand roundings of positions of a metre, and passed in 1e-12 s at 1
// m/s.
constexpr double touch_depth = 1e-12;
constexpr double mendable = 1e-9;  // m, rad: smaller joint errors are left to the projection at the end of the step
constexpr int most_bisections = 100;

[[noreturn]] void fail(const std::string& what) { throw AccurateStepError("AccurateStep: " + what); }

bool finite(const State& state) {
  return std::ranges::all_of(state, [](const BodyNow& body) {
    return body.pose.position.allFinite() && body.pose.turn.allFinite() && body.twist.linear.allFinite() &&
           body.twist.angular.allFinite();
  });
}

void show_twist(dBodyID body, const Twist& twist) {
  dBodySetLinearVel(body, twist.linear[0], twist.linear[1], twist.linear[2]);
  dBodySetAngularVel(body, twist.angular[0], twist.angular[1], twist.angular[2]);
}

void show_pose(dBodyID body, const Pose& pose) {
  const dQuaternion q = {pose.turn[0], pose.turn[1], pose.turn[2], pose.turn[3]};
  dBodySetPosition(body, pose.position[0], pose.position[1], pose.position[2]);
  dBodySetQuaternion(body, q);
}

}  // namespace

class AccurateStep::World {
 public:
  World(dxWorld* world, dxSpace* space, AccurateStepOptions options)
      : world_(world), space_(space), options_(std::move(options)), motion_(read()) {
    if (dCheckConfiguration("ODE_double_precision") == 0) fail("needs a double-precision ODE");
  }

  void step(double h) {
    if (!(h > 0) || !std::isfinite(h)) fail("the step must be a positive number of seconds, not " + std::to_string(h));
    if (changed()) reread();
    read_state();
    touches_.clear();
    const Untouched guard(*this);
    if (fresh_) settle();
    advance(h);
    if (!finite(state_)) fail("the motion left the finite numbers");
    write();
    guard.dismiss();
    fresh_ = false;
  }

  const std::vector<Touch>& touches() const { return touches_; }
  const Mechanism& mechanism() const { return motion_.mechanism(); }

 private:
  /// Puts every body back, bit by bit, unless the step came to its end: looking for contacts moves them.
  class Untouched {
   public:
    explicit Untouched(const World& world) : world_(world) {
      if (world.space_ == nullptr || !world.options_.contact) return;
      for (const Body& body : world.mechanism().bodies) {
        Exact& pose = poses_.emplace_back();
        std::copy_n(dBodyGetPosition(body.id), 4, pose.position);
        std::copy_n(dBodyGetQuaternion(body.id), 4, pose.quaternion);
        std::copy_n(dBodyGetRotation(body.id), 12, pose.rotation);
        std::copy_n(dBodyGetLinearVel(body.id), 3, pose.velocity);
        std::copy_n(dBodyGetAngularVel(body.id), 3, pose.spin);
      }
    }
    ~Untouched() {
      if (done_) return;
      for (std::size_t i = 0; i < poses_.size(); ++i) {
        const dBodyID body = world_.mechanism().bodies[i].id;
        const Exact& pose = poses_[i];
        dBodySetPosition(body, pose.position[0], pose.position[1], pose.position[2]);
        dBodySetLinearVel(body, pose.velocity[0], pose.velocity[1], pose.velocity[2]);
        dBodySetAngularVel(body, pose.spin[0], pose.spin[1], pose.spin[2]);
        // Setting a quaternion normalises it and computes the matrix anew, which may change a last digit of either.
        std::copy_n(pose.quaternion, 4, const_cast<dReal*>(dBodyGetQuaternion(body)));
        std::copy_n(pose.rotation, 12, const_cast<dReal*>(dBodyGetRotation(body)));
      }
    }
    Untouched(const Untouched&) = delete;
    Untouched& operator=(const Untouched&) = delete;
    void dismiss() const { done_ = true; }

   private:
    struct Exact {
      dReal position[4], quaternion[4], rotation[12], velocity[3], spin[3];
    };
    const World& world_;
    std::vector<Exact> poses_;
    mutable bool done_ = false;
  };

  Mechanism read() {
    Mechanism mechanism = read_mechanism(world_, space_, options_.bodies);
    signature_ = signature(mechanism.bodies);
    for (std::size_t i = 0; i < mechanism.bodies.size(); ++i) number_[mechanism.bodies[i].id] = i;
    return mechanism;
  }

  void reread() {
    number_.clear();
    motion_ = Motion(read());
    resting_.clear();
    fresh_ = true;
  }

  /// Joints of all bodies and the number of geoms: what tells that the user changed the world.
  std::vector<const void*> signature(const std::vector<Body>& bodies) const {
    std::vector<const void*> all;
    sign(bodies, [&](const void* id) { all.push_back(id); });
    return all;
  }
  template <class See>
  void sign(const std::vector<Body>& bodies, See&& see) const {
    for (const Body& body : bodies) {
      const int count = dBodyGetNumJoints(body.id);
      for (int j = 0; j < count; ++j) see(dBodyGetJoint(body.id, j));
      see(nullptr);
    }
    if (space_ == nullptr) return;
    const int geoms = dSpaceGetNumGeoms(space_);
    for (int g = 0; g < geoms; ++g) see(dSpaceGetGeom(space_, g));
  }
  bool changed() const {
    std::size_t k = 0;
    bool same = true;
    sign(mechanism().bodies, [&](const void* id) { same = same && k < signature_.size() && signature_[k++] == id; });
    return !same || k != signature_.size();
  }

  void read_state() {
    const auto& bodies = mechanism().bodies;
    state_.resize(bodies.size());
    forces_.resize(bodies.size());
    dVector3 g;
    dWorldGetGravity(world_, g);
    const auto vector = [](const dReal* v) { return Vector3d(v[0], v[1], v[2]); };
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const dBodyID id = bodies[i].id;
      const dReal* q = dBodyGetQuaternion(id);
      state_[i] = {{vector(dBodyGetPosition(id)), {q[0], q[1], q[2], q[3]}},
                   {vector(dBodyGetLinearVel(id)), vector(dBodyGetAngularVel(id))}};
      forces_[i] = {vector(dBodyGetForce(id)), vector(dBodyGetTorque(id))};
      if (dBodyGetGravityMode(id) != 0) forces_[i].force += vector(g) / bodies[i].inverse_mass;
      if (!forces_[i].force.allFinite() || !forces_[i].torque.allFinite()) {
        fail("the force on body " + std::to_string(i) + " is not finite");
      }
    }
    if (!finite(state_)) fail("a position or velocity is not finite");
  }

  void settle() {
    const double error = motion_.project(state_, 10);
    check_gap(error);
  }
  void check_gap(double error) const {
    if (error > options_.start_gap) {
      fail("a joint is " + std::to_string(error) + " m or rad apart at the start of the step; at most " +
           std::to_string(options_.start_gap) + " are mended");
    }
  }

  void advance(double h) {
    const bool contacts = space_ != nullptr && options_.contact;
    double t = 0;
    int impacts = 0;
    resting_now_ = contacts ? still_resting() : Pairs{};
    for (;;) {
      const double left = h - t;
      double error = motion_.step(state_, forces_, left, next_);
      if (error > mendable) {
        check_gap(error);
        motion_.project(state_, 10);
        motion_.step(state_, forces_, left, next_);
      }
      if (!finite(next_)) fail("the motion left the finite numbers");
      if (!contacts) break;
      collide(next_);
      if (deepest() == nullptr) break;
      const double passed = locate(left);
      t += passed;
      impact(t, passed, ++impacts >= options_.most_impacts);
      if (t >= h) {
        next_ = state_;
        break;
      }
    }
    std::swap(state_, next_);
    if (contacts) hold_resting();
  }

  using Pair = std::pair<dGeomID, dGeomID>;
  using Pairs = std::set<Pair>;

  // ODE's collision detection at a pose.
  void collide(const State& state) {
    for (std::size_t i = 0; i < state.size(); ++i) show_pose(mechanism().bodies[i].id, state[i].pose);
    contacts_.clear();
    pairs_.clear();
    dSpaceCollide(space_, this, &near);
  }

  static void near(void* data, dGeomID one, dGeomID other) {
    World& world = *static_cast<World*>(data);
    if (dGeomIsSpace(one) != 0 || dGeomIsSpace(other) != 0) {
      dSpaceCollide2(one, other, data, &near);
      return;
    }
    const dBodyID a = dGeomGetBody(one);
    const dBodyID b = dGeomGetBody(other);
    if (a == b || (a != nullptr && b != nullptr && dAreConnected(a, b) != 0)) return;
    const auto bounce = world.options_.contact(one, other);
    if (!bounce) return;
    constexpr int most = 64;
    dContactGeom found[most];
    const int count = dCollide(one, other, most, found, sizeof(dContactGeom));
    if (count == 0) return;
    const std::size_t pair = world.pairs_.size();
    world.pairs_.push_back(std::minmax(one, other));
    for (int i = 0; i < count; ++i) {
      const dContactGeom& geom = found[i];
      // The normal takes the first geom of the contact out of the second.
      const auto number = [&](dGeomID g) {
        const auto at = world.number_.find(dGeomGetBody(g));
        return at == world.number_.end() ? world_body : at->second;
      };
      world.contacts_.push_back({number(geom.g1),
                                 number(geom.g2),
                                 {geom.pos[0], geom.pos[1], geom.pos[2]},
                                 {geom.normal[0], geom.normal[1], geom.normal[2]},
                                 geom.depth,
                                 bounce->restitution,
                                 pair});
    }
  }

  bool rests(const Contact& contact) const { return resting_now_.contains(pairs_[contact.pair]); }

  /// The deepest contact that is not at rest, if any.
  const Contact* deepest() const {
    const Contact* found = nullptr;
    for (const Contact& contact : contacts_) {
      if (contact.depth > 0 && !rests(contact) && (found == nullptr || contact.depth > found->depth)) found = &contact;
    }
    return found;
  }

  /// The first touch in a step of length `left` that ends in contact; `next_` becomes the state there. Newton's method
  /// on ODE's depth, which exists on one side only, within a bracket.
  double locate(double left) {
    double free = 0;
    double touching = left;
    double depth = deepest()->depth;
    double closing = -normal_speed(*deepest(), next_);
    bool fell_short = false;  // Newton's method, which then needs a better start
    for (int round = 0; round < most_bisections && depth > touch_depth; ++round) {
      const double newton = closing > 0 && !fell_short ? touching - (depth - touch_depth / 2) / closing : free;
      const double guess = newton > free && newton < touching ? newton : (free + touching) / 2;
      if (!(guess > free && guess < touching)) break;
      motion_.step(state_, forces_, guess, trial_);
      collide(trial_);
      fell_short = deepest() == nullptr;
      if (fell_short) {
        free = guess;
        continue;
      }
      touching = guess;
      std::swap(next_, trial_);
      depth = deepest()->depth;
      closing = -normal_speed(*deepest(), next_);
    }
    collide(next_);
    motion_.project(next_, 1);  // the matrix of this pose, for the impulses
    return touching;
  }

  void impact(double t, double passed, bool last) {
    std::swap(state_, next_);
    const double before = slowest_normal_speed();
    Touch& touch = touches_.emplace_back(Touch{t, -before, 0, contacts_.size()});
    tell(options_.before_impact, touch);
    strike(motion_, contacts_, options_.rest_speed, state_);
    touch.departure = slowest_normal_speed();
    tell(options_.after_impact, touch);
    // What came slowly stays, and so does what comes again and again without time passing.
    for (const Contact& contact : contacts_) {
      if (last || -before < options_.rest_speed || passed <= 0) resting_now_.insert(pairs_[contact.pair]);
    }
  }

  void tell(const std::function<void(const Touch&)>& observer, const Touch& touch) const {
    if (!observer) return;
    for (std::size_t i = 0; i < state_.size(); ++i) {
      show_pose(mechanism().bodies[i].id, state_[i].pose);
      show_twist(mechanism().bodies[i].id, state_[i].twist);
    }
    observer(touch);
  }

  double slowest_normal_speed() const {
    double slowest = INFINITY;
    for (const Contact& contact : contacts_) slowest = std::min(slowest, normal_speed(contact, state_));
    return slowest;
  }

  /// Pairs that rested at the end of the last step, unless something has set them moving.
  Pairs still_resting() {
    if (resting_.empty()) return {};
    collide(state_);
    Pairs rest = resting_;
    for (const Contact& contact : contacts_) {
      if (std::fabs(normal_speed(contact, state_)) > options_.rest_speed) rest.erase(pairs_[contact.pair]);
    }
    return rest;
  }

  /// At the end of a step: what rests stops and is pushed out of what it rests on.
  void hold_resting() {
    resting_.clear();
    if (resting_now_.empty()) return;
    for (int round = 0; round < 3; ++round) {
      collide(state_);
      std::erase_if(contacts_, [this](const Contact& contact) { return !rests(contact); });
      if (contacts_.empty()) return;
      for (const Contact& contact : contacts_) resting_.insert(pairs_[contact.pair]);
      motion_.project(state_, 1);
      if (round == 0) strike(motion_, contacts_, INFINITY, state_);
      push_out(motion_, contacts_, touch_depth, state_);
    }
  }

  void write() {
    const auto& bodies = mechanism().bodies;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const dBodyID id = bodies[i].id;
      show_pose(id, state_[i].pose);
      show_twist(id, state_[i].twist);
      dBodySetForce(id, 0, 0, 0);
      dBodySetTorque(id, 0, 0, 0);
    }
    const auto& joints = mechanism().joints;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      dJointFeedback* const feedback = dJointGetFeedback(joints[j].id);
      if (feedback == nullptr) continue;
      // ODE writes the force on the body it holds as the first.
      const Wrench on_a = motion_.force_on_a(j);
      const auto put = [](const Vector3d& v, dReal* to) { std::copy_n(v.data(), 3, to); };
      put(on_a.force, feedback->f1);
      put(on_a.torque, feedback->t1);
      if (joints[j].b == world_body) continue;
      const Wrench on_b = motion_.force_on_b(j);
      put(on_b.force, feedback->f2);
      put(on_b.torque, feedback->t2);
    }
  }

  dWorldID world_;
  dSpaceID space_;
  AccurateStepOptions options_;
  std::vector<const void*> signature_;
  std::map<dBodyID, std::size_t> number_;
  Motion motion_;
  bool fresh_ = true;
  State state_, next_, trial_;
  std::vector<Wrench> forces_;
  std::vector<Contact> contacts_;
  std::vector<Pair> pairs_;  // of the contacts
  Pairs resting_, resting_now_;
  std::vector<Touch> touches_;
};

AccurateStep::AccurateStep(dxWorld* world, dxSpace* space, AccurateStepOptions options)
    : world_(std::make_unique<World>(world, space, std::move(options))) {}
AccurateStep::~AccurateStep() = default;
AccurateStep::AccurateStep(AccurateStep&&) noexcept = default;
AccurateStep& AccurateStep::operator=(AccurateStep&&) noexcept = default;
void AccurateStep::operator()(double h) { world_->step(h); }
const std::vector<Touch>& AccurateStep::touches() const { return world_->touches(); }
std::size_t AccurateStep::bodies() const { return world_->mechanism().bodies.size(); }
std::size_t AccurateStep::joints() const { return world_->mechanism().joints.size(); }

}  // namespace odeval
