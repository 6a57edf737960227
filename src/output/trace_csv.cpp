#include "output/trace_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"

namespace odeval {

namespace {

/// The columns of a trace in the order of the file.
class Layout {
 public:
  explicit Layout(const Trace& trace) : rows_(trace.rows()), energy_(trace.kinetic), drift_(trace.kinetic.size()) {
    for (std::size_t k = 0; k < energy_.size(); ++k) {
      energy_[k] += trace.potential[k];
      drift_[k] = energy_[k] - energy_[0];
    }
    add("t", trace.t);
    add_each("q", trace.q);
    add_each("qd", trace.qd);
    add("kinetic", trace.kinetic);
    add("potential", trace.potential);
    add("energy", energy_);
    add("energy_drift", drift_);
    add("gap", trace.gap);
    add("out_of_plane", trace.out_of_plane);
    add_each("error_q", trace.error_q);
    add_each("error_position", trace.error_position);
    add_each("error_turn", trace.error_turn);
    add("angular_momentum_drift", trace.angular_momentum_drift);
    add("penetration", trace.penetration);
    add("contacts", trace.contacts);
    add("condition", trace.condition);
    add("manipulability", trace.manipulability);
    for (std::size_t i = 0; i < trace.bodies.size(); ++i) add_body(std::to_string(i + 1), trace.bodies[i]);
  }
  Layout(const Layout&) = delete;
  Layout& operator=(const Layout&) = delete;

  const std::string& header() const { return header_; }
  const std::vector<const double*>& columns() const { return columns_; }

 private:
  void add(const std::string& name, const Column& column) {
    if (column.size() != rows_ || rows_ == 0) return;
    if (!header_.empty()) header_ += ',';
    header_ += name;
    columns_.push_back(column.data());
  }

  void add_each(const std::string& name, const std::vector<Column>& columns) {
    for (std::size_t i = 0; i < columns.size(); ++i) add(name + std::to_string(i + 1), columns[i]);
  }

  void add_body(const std::string& link, const BodyColumns& body) {
    add_vector("", link, body.position);
    for (std::size_t d = 0; d < 9; ++d) {
      add(fmt::format("r{}{}{}", link, d / 3 + 1, d % 3 + 1), body.rotation[d]);
    }
    add_vector("v", link, body.velocity);
    add_vector("w", link, body.spin);
    add_vector("f", link, body.joint_force);
  }

  void add_vector(const std::string& letter, const std::string& link, const std::array<Column, 3>& vector) {
    add(letter + "x" + link, vector[0]);
    add(letter + "y" + link, vector[1]);
    add(letter + "z" + link, vector[2]);
  }

  std::size_t rows_;
  Column energy_;
  Column drift_;
  std::string header_;
  std::vector<const double*> columns_;
};

std::string_view next_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::string_view next_cell(std::string_view& line, bool& more) {
  const std::size_t comma = line.find(',');
  more = comma != std::string_view::npos;
  const std::string_view cell = line.substr(0, comma);
  line.remove_prefix(more ? comma + 1 : line.size());
  return cell;
}

}  // namespace

std::string trace_csv(const Trace& trace) {
  const Layout layout(trace);
  const std::size_t rows = trace.rows();
  std::vector<char> line(layout.columns().size() * (longest_number + 1) + 1);

  std::string text = layout.header() + '\n';
  constexpr std::size_t enough = 20;  // characters a cell; memory that is never touched costs nothing
  text.reserve(text.size() + rows * layout.columns().size() * enough);
  for (std::size_t k = 0; k < rows; ++k) {
    char* end = line.data();
    for (const double* column : layout.columns()) {
      if (end != line.data()) *end++ = ',';
      end = put_number(end, column[k]);
    }
    *end++ = '\n';
    text.append(line.data(), end);
  }
  return text;
}

CsvColumns parse_csv(std::string_view text, const std::string& name) {
  CsvColumns table;
  bool more = !text.empty();
  for (std::string_view head = next_line(text); more;) table.header.emplace_back(next_cell(head, more));
  table.columns.resize(table.header.size());

  for (long number = 2; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    more = true;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      if (!more) throw UserError(fmt::format("{}:{}: has fewer cells than the header", name, number));
      const std::string_view cell = next_cell(line, more);
      double value = 0;
      const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
      if (error != std::errc() || stop != cell.data() + cell.size()) {
        throw UserError(fmt::format("{}:{}: {}: '{}' is no number", name, number, table.header[i], cell));
      }
      table.columns[i].push_back(value);
    }
    if (more) throw UserError(fmt::format("{}:{}: has more cells than the header", name, number));
  }
  return table;
}

CsvColumns read_csv(const std::filesystem::path& file) { return parse_csv(read_whole(file), file.string()); }

}  // namespace odeval
