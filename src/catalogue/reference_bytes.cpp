#include "catalogue/reference_bytes.hpp"

#include "output/bytes.hpp"

namespace odeval {

template <class Way, class Value>
requires bytes::is<Value, Impact>
void pass(Way& way, Value& impact) {
  auto& [t, q1, qd_before, qd_after, depth, link] = impact;
  each(way, t, q1, qd_before, qd_after, depth, link);
}

template <class Way, class Value>
requires bytes::is<Value, BodyColumns>
void pass(Way& way, Value& body) {
  auto& [position, rotation, velocity, spin, joint_force] = body;
  each(way, position, rotation, velocity, spin, joint_force);
}

template <class Way, class Value>
requires bytes::is<Value, JointColumns>
void pass(Way& way, Value& joint) {
  auto& [gap, q, qd, load, error_q] = joint;
  each(way, gap, q, qd, load, error_q);
}

template <class Way, class Value>
requires bytes::is<Value, StopStrike>
void pass(Way& way, Value& strike) {
  auto& [t, joint, motion, low, rate_before, rate_after] = strike;
  each(way, t, joint, motion, low, rate_before, rate_after);
}

template <class Way, class Value>
requires bytes::is<Value, Trace>
void pass(Way& way, Value& trace) {
  auto& [t, q, qd, kinetic, potential, gap, out_of_plane, error_q, error_position, error_turn, angular_momentum_drift,
         long_axis_spin, penetration, contacts, condition, manipulability, works, unaccounted, bodies, joints,
         body_names, joint_names] = trace;
  each(way, t, q, qd, kinetic, potential, gap, out_of_plane, error_q, error_position, error_turn,
       angular_momentum_drift, long_axis_spin, penetration, contacts, condition, manipulability, works, unaccounted,
       bodies, joints, body_names, joint_names);
}

template <class Way, class Value>
requires bytes::is<Value, Reference>
void pass(Way& way, Value& reference) {
  auto& [trace, uncertainty_q, uncertainty_position, uncertainty_turn, uncertainty_spin, joint_force, impacts,
         impact_uncertainty_s, strikes, at_rest_from, origin] = reference;
  each(way, trace, uncertainty_q, uncertainty_position, uncertainty_turn, uncertainty_spin, joint_force, impacts,
       impact_uncertainty_s, strikes, at_rest_from, origin);
}

namespace catalogue {

std::string reference_bytes(const Reference& reference) { return bytes::of(reference); }

Reference reference_of(std::string_view bytes) { return odeval::bytes::read<Reference>(bytes); }

}  // namespace catalogue
}  // namespace odeval
