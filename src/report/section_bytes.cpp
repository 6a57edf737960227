#include "report/section_bytes.hpp"

#include "output/bytes.hpp"

namespace odeval::report {

template <class Way, bytes::is<Missing> Value>
void pass(Way& way, Value& value) {
  auto& [why] = value;
  pass(way, why);
}

template <class Way, bytes::is<Text> Value>
void pass(Way& way, Value& value) {
  auto& [text] = value;
  pass(way, text);
}

template <class Way, bytes::is<Table> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, columns, rows, note] = value;
  pass(way, name);
  pass(way, title);
  pass(way, columns);
  pass(way, rows);
  pass(way, note);
}

template <class Way, bytes::is<Series> Value>
void pass(Way& way, Value& value) {
  auto& [label, x, y, mark, colour, dashed] = value;
  pass(way, label);
  pass(way, x);
  pass(way, y);
  pass(way, mark);
  pass(way, colour);
  pass(way, dashed);
}

template <class Way, bytes::is<Shade> Value>
void pass(Way& way, Value& value) {
  auto& [from, why] = value;
  pass(way, from);
  pass(way, why);
}

template <class Way, bytes::is<Panel> Value>
void pass(Way& way, Value& value) {
  auto& [x_label, y_label, series, log_x, log_y, equal_axes, shade, y_range] = value;
  pass(way, x_label);
  pass(way, y_label);
  pass(way, series);
  pass(way, log_x);
  pass(way, log_y);
  pass(way, equal_axes);
  pass(way, shade);
  pass(way, y_range);
}

template <class Way, bytes::is<Figure> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, caption, panels, columns] = value;
  pass(way, name);
  pass(way, title);
  pass(way, caption);
  pass(way, panels);
  pass(way, columns);
}

template <class Way, bytes::is<Picture> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, caption, png] = value;
  pass(way, name);
  pass(way, title);
  pass(way, caption);
  pass(way, png);
}

template <class Way, bytes::is<Section> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, blocks] = value;
  pass(way, name);
  pass(way, title);
  pass(way, blocks);
}

template <class Way, bytes::is<Finding> Value>
void pass(Way& way, Value& value) {
  auto& [meaning, unit, number, uncertainty, missing] = value;
  pass(way, meaning);
  pass(way, unit);
  pass(way, number);
  pass(way, uncertainty);
  pass(way, missing);
}

template <class Way, bytes::is<Outcome> Value>
void pass(Way& way, Value& value) {
  auto& [section, findings, failures] = value;
  pass(way, section);
  pass(way, findings);
  pass(way, failures);
}

std::string outcome_bytes(const Outcome& outcome) { return bytes::of(outcome); }

Outcome outcome_of(std::string_view bytes) { return odeval::bytes::read<Outcome>(bytes); }

}  // namespace odeval::report
