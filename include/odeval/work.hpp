#pragma once
// The energy that comes into a mechanism and goes out of it, by what does the work.
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace odeval {

struct Joint;

/// What does work on a mechanism beside its weight. Numbers are places in `Works`.
enum class Work : std::size_t {
  motors,       // of joints
  stops,        // of joints, as they are struck
  springs,      // of joints, struts and suspensions: what they held at t = 0 less what they hold now
  dampers,      // likewise
  torques,      // of joints, or forces along them
  controllers,  // of joints
  contacts,     // of bodies
};
/// As files call them, in the order of the enumeration.
inline constexpr std::array<std::string_view, 7> work_names{"motors",  "stops",       "springs", "dampers",
                                                            "torques", "controllers", "contacts"};
/// A number for each of them: of work J, since t = 0; of what acts along a joint N m or N.
using Works = std::array<double, work_names.size()>;

/// The one of that kind.
constexpr double& of(Works& works, Work kind) { return works[static_cast<std::size_t>(kind)]; }

/// What loads a joint at a time and a way q with its rate, by kinds; `held` is what controllers hold that look once a
/// step.
Works loads_by_kind(const Joint& joint, double t, double q, double rate, double held);

/// The energy in a joint's springs, J.
double elastic_energy(const Joint& joint, double q);

/// How long a motor was at its limit.
struct MotorUse {
  std::size_t joint = 0;          // number
  double share = 0;               // of the time of the run, 0 to 1
  std::optional<double> first_s;  // when it came to its limit first
  std::size_t motion = 0;         // of a joint with several: its number in files, from 1
};

/// A joint that strikes an end of its way. Numbers count as the joint's (mechanism.hpp).
struct StopStrike {
  double t = 0;            // s, of the step that saw it, or of the moment itself
  std::size_t joint = 0;   // number
  std::size_t motion = 0;  // of a joint with several: its number in files, from 1
  bool low = false;        // which end
  double rate_before = 0;  // rad/s or m/s
  double rate_after = 0;   // likewise
};

}  // namespace odeval
