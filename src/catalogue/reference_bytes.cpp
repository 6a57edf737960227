#include "catalogue/reference_bytes.hpp"

#include <array>
#include <cstring>
#include <optional>
#include <type_traits>

namespace odeval::catalogue {
namespace {

// One function a type, for both ways. Each takes its structure apart whole, so that one that gets another member does
// not compile until it is passed on as well.
struct Writer {
  std::string bytes;

  void raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }
};

struct Reader {
  std::string_view rest;

  void raw(void* data, std::size_t size) {
    if (size > 0) std::memcpy(data, rest.data(), size);
    rest.remove_prefix(size);
  }
};

template <class Way, class Value>
requires std::is_arithmetic_v<std::remove_const_t<Value>>
void pass(Way& way, Value& value) { way.raw(&value, sizeof value); }

template <class Way, class Values>
void pass_sized(Way& way, Values& values) {
  std::size_t size = values.size();
  pass(way, size);
  if constexpr (!std::is_const_v<Values>) values.resize(size);
}

template <class Way>
void pass(Way& way, const std::string& text) {
  pass_sized(way, text);
  way.raw(text.data(), text.size());
}
template <class Way>
void pass(Way& way, std::string& text) {
  pass_sized(way, text);
  way.raw(text.data(), text.size());
}

template <class Way>
void pass(Way& way, const Column& column) {
  pass_sized(way, column);
  way.raw(column.data(), column.size() * sizeof(double));
}
template <class Way>
void pass(Way& way, Column& column) {
  pass_sized(way, column);
  way.raw(column.data(), column.size() * sizeof(double));
}

template <class Way>
void pass(Way& way, const std::optional<int>& number) {
  const int value = number.value_or(-1);
  pass(way, value);
}
template <class Way>
void pass(Way& way, std::optional<int>& number) {
  int value = 0;
  pass(way, value);
  number = value < 0 ? std::nullopt : std::optional(value);
}

template <class Way, class Value, std::size_t count>
void pass(Way& way, std::array<Value, count>& values);
template <class Way, class Value, std::size_t count>
void pass(Way& way, const std::array<Value, count>& values);

template <class Way, class Value>
requires std::is_same_v<std::remove_const_t<Value>, Impact>
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
requires std::is_same_v<std::remove_const_t<Value>, BodyColumns>
void pass(Way& way, Value& body) {
  auto& [position, rotation, velocity, spin, joint_force] = body;
  pass(way, position);
  pass(way, rotation);
  pass(way, velocity);
  pass(way, spin);
  pass(way, joint_force);
}

template <class Way, class Value>
void pass(Way& way, std::vector<Value>& values) {
  pass_sized(way, values);
  for (Value& value : values) pass(way, value);
}
template <class Way, class Value>
void pass(Way& way, const std::vector<Value>& values) {
  pass_sized(way, values);
  for (const Value& value : values) pass(way, value);
}

template <class Way, class Value, std::size_t count>
void pass(Way& way, std::array<Value, count>& values) {
  for (Value& value : values) pass(way, value);
}
template <class Way, class Value, std::size_t count>
void pass(Way& way, const std::array<Value, count>& values) {
  for (const Value& value : values) pass(way, value);
}

template <class Way, class Value>
requires std::is_same_v<std::remove_const_t<Value>, Trace>
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
requires std::is_same_v<std::remove_const_t<Value>, Reference>
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

}  // namespace

std::string reference_bytes(const Reference& reference) {
  Writer writer;
  pass(writer, reference);
  return std::move(writer.bytes);
}

Reference reference_of(std::string_view bytes) {
  Reader reader{bytes};
  Reference reference;
  pass(reader, reference);
  return reference;
}

}  // namespace odeval::catalogue
