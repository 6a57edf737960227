#include "catalogue/reference_bytes.hpp"

#include "output/bytes.hpp"

namespace odeval {

template <class Way, class Value>
requires bytes::is<Value, Impact>
void pass(Way& way, Value& impact) {
  auto& [t, q1, qd_before, qd_after, depth, link] = impact;
  pass(way, t);
  pass(way, q1);
  pass(way, qd_before);
  pass(way, qd_after);
  pass(way, depth);
  pass(way, link);
}

template <class Way, class Value>
requires bytes::is<Value, BodyColumns>
void pass(Way& way, Value& body) {
  auto& [position, rotation, velocity, spin, joint_force] = body;
  pass(way, position);
  pass(way, rotation);
  pass(way, velocity);
  pass(way, spin);
  pass(way, joint_force);
}

template <class Way, class Value>
requires bytes::is<Value, Trace>
void pass(Way& way, Value& trace) {
  auto& [t, q, qd, kinetic, potential, gap, out_of_plane, error_q, error_position, error_turn, angular_momentum_drift,
         long_axis_spin, penetration, contacts, condition, manipulability, bodies] = trace;
  pass(way, t);
  pass(way, q);
  pass(way, qd);
  pass(way, kinetic);
  pass(way, potential);
  pass(way, gap);
  pass(way, out_of_plane);
  pass(way, error_q);
  pass(way, error_position);
  pass(way, error_turn);
  pass(way, angular_momentum_drift);
  pass(way, long_axis_spin);
  pass(way, penetration);
  pass(way, contacts);
  pass(way, condition);
  pass(way, manipulability);
  pass(way, bodies);
}

template <class Way, class Value>
requires bytes::is<Value, Reference>
void pass(Way& way, Value& reference) {
  auto& [trace, uncertainty_q, uncertainty_position, uncertainty_turn, uncertainty_spin, joint_force, impacts,
         impact_uncertainty_s, at_rest_from, described] = reference;
  pass(way, trace);
  pass(way, uncertainty_q);
  pass(way, uncertainty_position);
  pass(way, uncertainty_turn);
  pass(way, uncertainty_spin);
  pass(way, joint_force);
  pass(way, impacts);
  pass(way, impact_uncertainty_s);
  pass(way, at_rest_from);
  pass(way, described);
}

namespace catalogue {

std::string reference_bytes(const Reference& reference) { return bytes::of(reference); }

Reference reference_of(std::string_view bytes) { return odeval::bytes::read<Reference>(bytes); }

}  // namespace catalogue
}  // namespace odeval
