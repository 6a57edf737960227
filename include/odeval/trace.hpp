#pragma once
// What a run yields: columns over time, the same for every method.
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace odeval {

using Column = std::vector<double>;

/// Columns of one link, world frame; units as in BodyState.
struct BodyColumns {
  std::array<Column, 3> position;
  std::array<Column, 9> rotation;  // by rows
  std::array<Column, 3> velocity;
  std::array<Column, 3> spin;
  std::array<Column, 3> joint_force;
};

/// Columns of one joint. It counts as files do: the child against the parent, from t = 0.
struct JointColumns {
  Column gap;      // m, between its two anchors, across what it leaves free
  Column q;        // of a hinge or a slider, rad or m, without jumps; else empty
  Column qd;       // likewise, rad/s or m/s
  Column load;     // likewise, N m or N, of motor, stop, springs, torques and controllers; empty where nobody tells it
  Column error_q;  // likewise, against the reference; empty without one
};

/// K samples of n links or bodies. All columns have K rows, or none where they have no meaning.
struct Trace {
  Column t;                             // s
  std::vector<Column> q;                // n columns, rad, unwrapped
  std::vector<Column> qd;               // n columns, rad/s
  Column kinetic;                       // J
  Column potential;                     // J, 0 with all centres at the first hinge's height, of bodies at z = 0
  Column gap;                           // m, largest distance between the two anchors of a joint; empty without joints
  Column out_of_plane;                  // m, largest distance of a body from the plane of motion
  std::vector<Column> error_q;          // n columns, rad, against the reference; empty without one
  std::vector<Column> error_position;   // a column a body, m, distance from the reference's centre; empty for pendulums
  std::vector<Column> error_turn;       // a column a body, rad, angle between its attitude and the reference's
  Column angular_momentum_drift;        // N m s, |L - L at t = 0|, each body about its centre; empty where torques act
  std::vector<Column> long_axis_spin;   // a column a body, rad/s, about its longest side (a link's length)
  Column penetration;                   // m, deepest overlap of a body with the ground; empty without one
  Column contacts;                      // contact joints in the step that led to the row
  Column condition;                     // 1-norm condition number of the matrix that the formulation inverts
  Column manipulability;                // least over largest eigenvalue of J^T J of the chain's end (report D.4)
  std::vector<Column> works;            // J, a column for each kind of work since t = 0; none where nobody tells them
  Column unaccounted;                   // J, change of the energy since t = 0 that no work accounts for; likewise
  std::vector<BodyColumns> bodies;      // n, or none in generalized coordinates
  std::vector<JointColumns> joints;     // of a mechanism whose parts have names
  std::vector<std::string> body_names;  // likewise, by which files call their columns; else by number
  std::vector<std::string> joint_names;  // likewise

  std::size_t rows() const { return t.size(); }
};

}  // namespace odeval
