#pragma once
// Mechanisms whose joints make trees: the equations of motion.hpp solved from the leaves to the root and back, by
// R. Featherstone's articulated-body recursion (Rigid Body Dynamics Algorithms, chapter 7) in world axes.
//
// A link is a body with the joint on its way to the root: the world, or the first body of a tree that hangs on nothing.
// Its origin is the point the joint holds it at. A universal joint makes two links, the first without mass. Over a
// joint, accelerations (and velocities, and displacements) of the origins go on as
//
//   turning = turning of the parent + s axis + offset,  moving = moving of the parent + its turning x arm + offset
//
// of a joint that turns; of a slider `s axis` is in the second. s takes the value that the forces want, and the offset
// is what the rows of mechanism.hpp ask for: the very solution of the equations with multipliers, to rounding, also
// where a state does not quite keep the joints.
#include <optional>
#include <vector>

#include "engines/ode_rk4/mechanism.hpp"

namespace odeval::engine_rk4 {

struct JointError;
struct Wrench;

/// A symmetric 3 x 3 matrix.
struct Symmetric {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  Vector3d operator*(const Vector3d& v) const {
    return {xx * v[0] + xy * v[1] + xz * v[2], xy * v[0] + yy * v[1] + yz * v[2], xz * v[0] + yz * v[1] + zz * v[2]};
  }
  /// Less v w', where w is a multiple of v.
  void take(const Vector3d& v, const Vector3d& w) {
    xx -= v[0] * w[0];
    yy -= v[1] * w[1];
    zz -= v[2] * w[2];
    xy -= v[0] * w[1];
    xz -= v[0] * w[2];
    yz -= v[1] * w[2];
  }
  void add(const Symmetric& other) {
    xx += other.xx;
    yy += other.yy;
    zz += other.zz;
    xy += other.xy;
    xz += other.xz;
    yz += other.yz;
  }
  Matrix3d full() const { return (Matrix3d() << xx, xy, xz, xy, yy, yz, xz, yz, zz).finished(); }
  static Symmetric of(const Matrix3d& m) { return {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)}; }
};

class Tree {
 public:
  /// Nothing where joints close a loop, are of a kind that is not known here or have motors, or where a body is
  /// kinematic or damped.
  static std::optional<Tree> of(const Mechanism& mechanism);

  /// Takes the pose of a state: what follows is of it. `factor` takes more time than `look`; a factor of a pose nearby
  /// changes how corrections are shared, to the first order in the distance, and not that they are made. Where that
  /// would cost momentum, of what hangs on nothing and in answers to impulses, the factor is brought up to date.
  void look(const State& state);
  void factor();
  /// How far joints are apart in the state looked at. Returns the farthest.
  JointError find_gaps();

  /// Accelerations under forces, at the state looked at.
  void accelerate(const State& state, const std::vector<Wrench>& forces, std::vector<Twist>& accelerations);
  /// Displacements that close the gaps found, to the first order; mass-weighted the smallest.
  void close(std::vector<Twist>& displacements);
  /// Changes of velocities that agree with the joints then, likewise.
  void agree(const State& state, std::vector<Twist>& changes);
  /// Changes of velocities that impulses make.
  void respond(const std::vector<Wrench>& impulses, std::vector<Twist>& changes);

  /// Of a joint at the last solution, on its first body, and torque about its centre; or on its second.
  Wrench force(std::size_t joint, bool on_a) const;

 private:
  friend class TreeBuilder;
  void refresh() {
    if (stale_) factor();
  }
  static constexpr std::size_t none = static_cast<std::size_t>(-1);
  enum class Kind { hinge, slider, universal, fixed, ball, free };

  struct Link {
    Kind kind;
    std::size_t parent = none;  // link; none: the world
    std::size_t body = none;    // none: without mass, the first link of a universal joint
    std::size_t joint = none;   // none: free
    std::size_t parent_body = world_body;
    bool is_a = false;  // the joint's first body
    // In the body's frame.
    Vector3d centre = Vector3d::Zero();  // from the origin
    Vector3d axis = Vector3d::Zero();
    Matrix3d same_turn = Matrix3d::Identity();  // axes that the parent's `same_turn` agrees with: fixed joints, sliders
    double mass = 0;
    Symmetric inertia = {};  // about the origin
    // In the parent's frame, or the world's.
    Vector3d arm = Vector3d::Zero();  // from the parent's origin to the joint
    Vector3d parent_axis = Vector3d::Zero();
    Matrix3d parent_same_turn = Matrix3d::Identity();
  };

  struct Offset {
    Vector3d turning, moving;
  };
  /// A link at the pose looked at, in world axes.
  struct Now {
    Matrix3d turn;         // of the body
    Vector3d place;        // of the origin
    Vector3d centre;       // of the body, from the origin
    Vector3d arm;          // from the parent's origin
    Vector3d apart;        // of it: what is beyond the joint's place on the parent
    Vector3d axis;         // of the joint, as the body has it
    Vector3d parent_axis;  // and as the parent has it
    Vector3d along;        // what s is about or along
    // Articulated inertia, of the link and all that hangs on it: torque about the origin and force are j turning + h
    // moving + n and h' turning + m moving + f.
    Symmetric inertia;  // of the body alone
    Symmetric j, m;
    Matrix3d h;
    // Of a joint with s. A unit of it loads the parent with `load_n` about its origin and `load_f`; divided by the
    // inertia that s has, these give what the parent's motion makes of s, and `share` what the link's load does.
    Vector3d load_n, load_f;
    Vector3d answer_n, answer_f, share;
    // Of what hangs on a ball joint: j^-1, j^-1 h; its j and h are zero then, and m is without what the ball leaves
    // free. Of a free body: inverse of j less its share in the motion of the origin, m^-1, m^-1 h'.
    Matrix3d inverse_j, inverse_m, coupling;
    Vector3d centripetal;  // acceleration of the centre against the origin
    Offset offset;
    // Of the solution at hand. Vectors that links hand on do not lie side by side: what is written in pairs across two
    // of them is slow to read.
    Vector3d n;   // with what the offset asks for, as f
    double push;  // s, were the parent still
    Vector3d f;
    double between_f_and_turning;
    Vector3d turning;
    double between_turning_and_moving;
    Vector3d moving;
    Offset gap;
  };
  struct Speeds;

  const Now& parent_of(const Link& link) const { return link.parent == none ? world_ : now_[link.parent]; }
  static bool has_joint(const Link& link) { return link.body != none && link.kind != Kind::free; }
  static bool has_s(const Link& link) {
    return link.kind == Kind::hinge || link.kind == Kind::slider || link.kind == Kind::universal;
  }
  static const Vector3d& parent_spin(const Link& link, const State& state);
  void gap(const Link& link, const Now& now, Offset& offset) const;
  static void slip(const Link& link, const Now& now, const State& state, Offset& offset);
  static void bias(const Link& link, const Now& now, const State& state, Offset& offset);
  static void eliminate(const Link& link, Now& now);
  static void hand_on(const Link& link, const Now& now, Now& parent);
  static void unload(Now& now);
  void solve(std::vector<Twist>& twists);
  void load_parents();                              // from the leaves to the roots
  void follow_parents(std::vector<Twist>& twists);  // and back

  std::vector<Link> links_;           // parents before children
  std::vector<std::size_t> link_of_;  // of each joint
  bool floats_ = false;               // some hang together and not on the world
  bool stale_ = true;                 // the factor is of a pose before
  Now world_;
  std::vector<Now> now_;
};

}  // namespace odeval::engine_rk4
