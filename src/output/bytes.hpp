#pragma once
// Values as bytes, to pass them from one process of this program to another. The bytes are not checked.
//
// `pass(way, value)` goes both ways: a Writer takes the value's bytes, a Reader fills it. A structure has a `pass`
// beside it that takes it apart whole by a structured binding, so that one that gets another member does not compile
// until it is passed on as well.
#include <array>
#include <cstddef>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace odeval::bytes {

struct Writer {
  static constexpr bool reads = false;
  std::string bytes;

  void raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }
};

struct Reader {
  static constexpr bool reads = true;
  std::string_view rest;

  void raw(void* data, std::size_t size) {
    if (size > 0) std::memcpy(data, rest.data(), size);
    rest.remove_prefix(size);
  }
};

/// Whether a value to write (constant) or to read is of that type.
template <class Value, class Type>
concept is = std::is_same_v<std::remove_const_t<Value>, Type>;

template <class Value, template <class...> class Template>
inline constexpr bool is_made_of = false;
template <template <class...> class Template, class... Types>
inline constexpr bool is_made_of<Template<Types...>, Template> = true;
template <class Value, template <class...> class Template>
concept made_of = is_made_of<std::remove_const_t<Value>, Template>;

template <class Value>
inline constexpr bool is_array = false;
template <class Element, std::size_t count>
inline constexpr bool is_array<std::array<Element, count>> = true;

template <class Value>
concept number = std::is_arithmetic_v<std::remove_const_t<Value>> || std::is_enum_v<std::remove_const_t<Value>>;

template <class Way, number Value>
void pass(Way& way, Value& value) {
  way.raw(&value, sizeof value);
}

template <class Way, class Values>
void pass_size(Way& way, Values& values) {
  std::size_t size = values.size();
  pass(way, size);
  if constexpr (Way::reads) values.resize(size);
}

template <class Way, is<std::string> Value>
void pass(Way& way, Value& text) {
  pass_size(way, text);
  way.raw(text.data(), text.size());
}

template <class Way, made_of<std::optional> Value>
void pass(Way& way, Value& value) {
  bool there = value.has_value();
  pass(way, there);
  if constexpr (Way::reads) {
    if (there) value.emplace();
  }
  if (there) pass(way, *value);
}

template <class Way, made_of<std::pair> Value>
void pass(Way& way, Value& value) {
  pass(way, value.first);
  pass(way, value.second);
}

template <class Way, class Value>
requires(is_array<std::remove_const_t<Value>>) void pass(Way& way, Value& values) {
  for (auto& value : values) pass(way, value);
}

template <class Way, made_of<std::vector> Value>
void pass(Way& way, Value& values) {
  pass_size(way, values);
  if constexpr (number<typename Value::value_type>) {
    way.raw(values.data(), values.size() * sizeof(typename Value::value_type));
  } else {
    for (auto& value : values) pass(way, value);
  }
}

template <class Way, made_of<std::variant> Value>
void pass(Way& way, Value& value) {
  std::size_t index = value.index();
  pass(way, index);
  if constexpr (Way::reads) {
    [&]<std::size_t... i>(std::index_sequence<i...>) {
      ((index == i ? void(value.template emplace<i>()) : void()), ...);
    }
    (std::make_index_sequence<std::variant_size_v<Value>>());
  }
  std::visit([&way](auto& alternative) { pass(way, alternative); }, value);
}

/// The members of a structure, one after the other.
template <class Way, class... Values>
void each(Way& way, Values&... values) {
  (pass(way, values), ...);
}

template <class Value>
std::string of(const Value& value) {
  Writer writer;
  pass(writer, value);
  return std::move(writer.bytes);
}

template <class Value>
Value read(std::string_view bytes) {
  Reader reader{bytes};
  Value value;
  pass(reader, value);
  return value;
}

}  // namespace odeval::bytes
