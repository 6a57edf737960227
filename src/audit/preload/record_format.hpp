#pragma once
// What the library that is loaded beside a program writes, and what reads it: plain bytes of this machine.
//
// A record is one page with the Head, a window, and then frames, one a step of the program and one before the first.
// Head and window are memory that is mapped from the file, and a window that is full is written behind what is there:
// so what the program leaves when it dies, by whatever signal, is whole frames, `Head::committed` bytes of them, the
// last of which, from `Head::behind` on, are in the window. A page that is mapped costs four times one that is written.
#include <cstddef>
#include <cstdint>

namespace odeval::audit {

constexpr std::uint64_t record_magic = 0x31'54'49'44'55'41'4f'2eULL;
constexpr std::size_t head_bytes = 4096;
constexpr std::size_t window_bytes = 1 << 18;

/// What a record is not, or not only.
enum Remark : std::uint32_t {
  single_precision = 1 << 0,   // the program's ODE, so that nothing was followed
  several_threads = 1 << 1,    // stepped: the program was ended there
  several_processes = 1 << 2,  // stepped: the record is of the first
  no_room = 1 << 3,            // for more: the record is of the program's beginning
  reached_until = 1 << 4,      // the simulated time asked for: the program was ended there
  contacts_stayed = 1 << 5,    // over some steps, since what made them could not be called again
  steps_in_vain = 1 << 6,      // dWorldStep returned 0
  not_accurately = 1 << 8,    // the accurate step can not take it, and last_words says why: the program was ended there
  record_full = 1 << 9,       // as much as it may be: the record is of the program's beginning
  pool_of_threads = 1 << 10,  // takes the steps, of ODE's own
  asked_the_clock = 1 << 11,  // the simulated one, or slept
  too_many_parts = 1 << 7,    // joints, pairs of bodies or geoms, so that some are not told of
};

struct Head {
  std::uint64_t magic;
  std::uint64_t committed;  // bytes of whole frames
  std::uint64_t behind;     // bytes that were written behind the window, of whole windows
  std::uint64_t steps;      // of the world of most, in the record
  double t;                 // s, of the world that went farthest, likewise
  std::uint32_t remarks;    // of Remark
  std::uint32_t refinement;
  // Of the first world that steps, before it does, without what is tried in their place:
  double erp;
  double cfm;
  double w;
  std::uint32_t iterations;
  std::uint32_t nothing;
  // Of Answer::solver, where there is a ledger:
  double direct;
  double iteration;
  double besides;
  std::uint64_t messages;   // of ODE
  double gravity[3];        // m/s², of the first world that steps, before it does
  double contact_s;         // shortest time in which a contact's damper, or spring, stops what it holds; 0: none
  char first_message[256];  // of ODE; empty: none
  char last_words[256];     // of ODE before it aborts; empty: none
};
static_assert(sizeof(Head) <= head_bytes);

/// Followed by as many bodies, their motions and the account: the latter two where there are any.
struct Frame {
  std::uint32_t bytes;  // of the frame with what follows it
  std::uint32_t world;  // in order of creation, from 0
  std::uint64_t step;   // of that world; 0 before the first
  double t;             // s, after the step
  double h;             // s
  double kinetic;       // J
  double potential;     // J
  double ode_s;         // in the step, with collision detection; 0: the clock was not asked
  std::uint32_t bodies;
  std::uint16_t has_motions;  // 1: of each body
  std::uint16_t has_account;
};

struct BodySample {
  std::uint32_t body;       // in order of creation, of all worlds
  std::uint32_t kinematic;  // 1: its velocity is the program's
  double position[3];
  double quaternion[4];
};

struct MotionSample {
  double velocity[3];
  double spin[3];
};

/// Of the run with a ledger.
struct Account {
  double gap;               // m, the largest of a joint
  std::uint32_t gap_joint;  // in order of creation from 1, contacts not counted; 0: none
  std::uint32_t quick;      // dWorldQuickStep
  std::uint32_t joints;     // contacts not counted
  std::uint32_t contacts;   // made for the step, of bodies
  std::uint32_t messages;   // of ODE in the step
  std::uint32_t nothing;
  double depth;  // m, the largest of those contacts
  // Work since the start of the world, J:
  double work_added;  // by forces and torques of the program
  double work_motors;
  double work_stops;
  double work_joints;  // otherwise
  double work_contacts;
  double work_damping;
  double work_program;  // between steps
};

/// A joint, or all contacts between two bodies, and what it came to at most. Beside the record in a file of
/// `parts_ending`, until a row of zeros.
struct PartSample {
  std::uint32_t type;            // dJointType
  std::uint32_t number;          // of a joint, in order of creation
  std::uint32_t bodies[2];       // in order of creation, from 1; 0: the world
  std::uint64_t steps;           // that it was there
  double largest_m;              // gap, or depth
  double largest_t;              // s
  double force;                  // N, on a body, of a contact the normal one
  double torque;                 // N m
  double work;                   // J, on both bodies
  double motor_work;             // J, of it by motors
  double stop_work;              // J, of it by stops
  std::uint64_t steps_at_limit;  // of a motor
  std::uint64_t steps_at_stop;
  double friction_share;        // of what friction may be
  std::uint64_t steps_sliding;  // with all of it
  std::uint64_t steps_rough;    // with a limit to friction
  std::uint64_t nothing;        // to be as long as a power of two
};
static_assert(sizeof(PartSample) == 128);
constexpr const char* parts_ending = ".parts";

/// A geom, beside the record in a file of `shapes_ending`, until a row of zeros.
struct ShapeSample {
  std::uint32_t kind;    // of Kind
  std::uint32_t body;    // in order of creation, from 1; 0: it stands in the world
  double size[3];        // m: sides; radius and length; of a plane its normal
  double position[3];    // of its centre, in the body's frame; of a plane its distance from the origin
  double quaternion[4];  // likewise
  double nothing[5];     // to be as long as a power of two

  enum Kind : std::uint32_t {
    none,
    box,
    sphere,
    capsule,
    cylinder,
    plane,
    bounds
  };  // bounds: of any other, when first seen
};
static_assert(sizeof(ShapeSample) == 128);
constexpr const char* shapes_ending = ".shapes";

/// What the program calls its bodies and joints stands beside the record, in a file of this ending: a line each, "body"
/// or "joint", its number and the name.
constexpr const char* names_ending = ".names";

}  // namespace odeval::audit
