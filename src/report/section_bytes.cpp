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
  auto& [text, evidence, lead] = value;
  each(way, text, evidence);
}

template <class Way, bytes::is<Table> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, columns, rows, note, evidence] = value;
  each(way, name, title, columns, rows, note, evidence);
}

template <class Way, bytes::is<Series> Value>
void pass(Way& way, Value& value) {
  auto& [label, x, y, mark, colour, dashed] = value;
  each(way, label, x, y, mark, colour, dashed);
}

template <class Way, bytes::is<Shade> Value>
void pass(Way& way, Value& value) {
  auto& [from, why] = value;
  each(way, from, why);
}

template <class Way, bytes::is<Panel> Value>
void pass(Way& way, Value& value) {
  auto& [title, x_label, y_label, series, log_x, log_y, equal_axes, shade, y_range] = value;
  each(way, title, x_label, y_label, series, log_x, log_y, equal_axes, shade, y_range);
}

template <class Way, bytes::is<Figure> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, caption, panels, columns] = value;
  each(way, name, title, caption, panels, columns);
}

template <class Way, bytes::is<Picture> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, caption, png] = value;
  each(way, name, title, caption, png);
}

template <class Way, bytes::is<Highlight> Value>
void pass(Way& way, Value& value) {
  auto& [sentence, figure, evidence] = value;
  each(way, sentence, figure, evidence);
}

template <class Way, bytes::is<Section> Value>
void pass(Way& way, Value& value) {
  auto& [name, title, blocks] = value;
  each(way, name, title, blocks);
}

template <class Way, bytes::is<Finding> Value>
void pass(Way& way, Value& value) {
  auto& [meaning, unit, number, uncertainty, missing, source, nearby] = value;
  each(way, meaning, unit, number, uncertainty, missing, source, nearby);
}

template <class Way, bytes::is<Outcome> Value>
void pass(Way& way, Value& value) {
  auto& [section, findings, failures] = value;
  each(way, section, findings, failures);
}

std::string outcome_bytes(const Outcome& outcome) { return bytes::of(outcome); }

Outcome outcome_of(std::string_view bytes) { return odeval::bytes::read<Outcome>(bytes); }

}  // namespace odeval::report
