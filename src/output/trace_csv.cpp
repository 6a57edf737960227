#include "output/trace_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "odeval/error.hpp"
#include "output/file.hpp"
#include "output/number.hpp"

namespace odeval {

namespace {

/// What a file calls a column of a body, by number or by name: "vx2" or "arm.vx"; of a matrix "r211" or "arm.r11".
std::string cell_of(const std::vector<std::string>& names, const std::string& column, std::size_t body,
                    std::optional<std::size_t> entry = {}) {
  const std::string place = entry ? fmt::format("{}{}", *entry / 3 + 1, *entry % 3 + 1) : "";
  if (names.empty()) return fmt::format("{}{}{}", column, body + 1, place);
  return body < names.size() ? fmt::format("{}.{}{}", names[body], column, place) : "";
}

/// The columns of a trace in the order of the file.
class Layout {
 public:
  explicit Layout(const Trace& trace) : trace_(trace) {
    for (const TraceColumn& row : trace_columns) {
      std::visit([&](auto place) { add_of_trace(std::string(row.name), place); }, row.place);
    }
    for (std::size_t body = 0; body < trace.bodies.size(); ++body) {
      for (const TraceColumn& row : trace_columns) {
        std::visit([&](auto place) { add_of_body(std::string(row.name), body, place); }, row.place);
      }
    }
    for (std::size_t joint = 0; joint < trace.joints.size(); ++joint) {
      for (const TraceColumn& row : trace_columns) {
        std::visit([&](auto place) { add_of_joint(row.name, joint, place); }, row.place);
      }
    }
  }
  Layout(const Layout&) = delete;
  Layout& operator=(const Layout&) = delete;

  const std::string& header() const { return header_; }
  const std::vector<const double*>& columns() const { return columns_; }

 private:
  void add(const std::string& name, const Column& column) {
    if (column.size() != trace_.rows() || column.empty()) return;
    if (!header_.empty()) header_ += ',';
    header_ += name;
    columns_.push_back(column.data());
  }

  void add_of_trace(const std::string& name, Column Trace::*place) { add(name, trace_.*place); }
  void add_of_trace(const std::string& name, Column (*make)(const Trace&)) {
    add(name, made_.emplace_back(make(trace_)));
  }
  void add_of_trace(const std::string& name, std::vector<Column> Trace::*place) {
    std::size_t number = 0;
    for (const Column& column : trace_.*place) add(cell_of(trace_.body_names, name, number++), column);
  }
  template <class Place>
  void add_of_trace(const std::string&, Place) {}  // body by body, joint by joint

  void add_of_body(const std::string& name, std::size_t body, std::array<Column, 3> BodyColumns::*place) {
    for (std::size_t d = 0; d < 3; ++d) {
      add(cell_of(trace_.body_names, name + "xyz"[d], body), (trace_.bodies[body].*place)[d]);
    }
  }
  void add_of_body(const std::string& name, std::size_t body, std::array<Column, 9> BodyColumns::*place) {
    for (std::size_t d = 0; d < 9; ++d) add(cell_of(trace_.body_names, name, body, d), (trace_.bodies[body].*place)[d]);
  }
  template <class Place>
  void add_of_body(const std::string&, std::size_t, Place) {}  // of the trace, or of a joint

  void add_of_joint(std::string_view name, std::size_t joint, Column JointColumns::*place) {
    add(fmt::format("{}.{}", trace_.joint_names[joint], name), trace_.joints[joint].*place);
  }
  template <class Place>
  void add_of_joint(std::string_view, std::size_t, Place) {}  // of the trace, or of a body

  const Trace& trace_;
  std::vector<Column> made_;
  std::string header_;
  std::vector<const double*> columns_;
};

/// The way back: columns of a file, by the names that `Layout` gives them.
class Unlayout {
 public:
  explicit Unlayout(const CsvColumns& table) : table_(table) {
    trace_.body_names = names_before(".x");
    trace_.joint_names = names_before(".gap");
    trace_.joints.resize(trace_.joint_names.size());
    for (const TraceColumn& row : trace_columns) {
      std::visit([&](auto place) { take_of_trace(std::string(row.name), place); }, row.place);
    }
    for (std::size_t body = 0;; ++body) {
      trace_.bodies.emplace_back();
      found_ = false;
      for (const TraceColumn& row : trace_columns) {
        std::visit([&](auto place) { take_of_body(std::string(row.name), body, place); }, row.place);
      }
      if (found_) continue;
      trace_.bodies.pop_back();
      break;
    }
    for (std::size_t joint = 0; joint < trace_.joints.size(); ++joint) {
      for (const TraceColumn& row : trace_columns) {
        std::visit([&](auto place) { take_of_joint(row.name, joint, place); }, row.place);
      }
    }
  }

  Trace trace() && { return std::move(trace_); }

 private:
  /// Of the cells that end so, in their order.
  std::vector<std::string> names_before(std::string_view end) const {
    std::vector<std::string> names;
    for (const std::string& cell : table_.header) {
      if (cell.ends_with(end)) names.push_back(cell.substr(0, cell.size() - end.size()));
    }
    return names;
  }

  bool take(const std::string& name, Column& column) {
    const auto found = std::ranges::find(table_.header, name);
    if (name.empty() || found == table_.header.end()) return false;
    column = table_.columns[static_cast<std::size_t>(found - table_.header.begin())];
    found_ = true;
    return true;
  }

  void take_of_trace(const std::string& name, Column Trace::*place) { take(name, trace_.*place); }
  void take_of_trace(const std::string& name, std::vector<Column> Trace::*place) {
    Column column;
    while (take(cell_of(trace_.body_names, name, (trace_.*place).size()), column)) {
      (trace_.*place).push_back(std::move(column));
    }
  }
  template <class Place>
  void take_of_trace(const std::string&, Place) {}  // made of others, or body by body

  void take_of_body(const std::string& name, std::size_t body, std::array<Column, 3> BodyColumns::*place) {
    for (std::size_t d = 0; d < 3; ++d) {
      take(cell_of(trace_.body_names, name + "xyz"[d], body), (trace_.bodies[body].*place)[d]);
    }
  }
  void take_of_body(const std::string& name, std::size_t body, std::array<Column, 9> BodyColumns::*place) {
    for (std::size_t d = 0; d < 9; ++d) {
      take(cell_of(trace_.body_names, name, body, d), (trace_.bodies[body].*place)[d]);
    }
  }
  template <class Place>
  void take_of_body(const std::string&, std::size_t, Place) {}  // of the trace, or of a joint

  void take_of_joint(std::string_view name, std::size_t joint, Column JointColumns::*place) {
    take(fmt::format("{}.{}", trace_.joint_names[joint], name), trace_.joints[joint].*place);
  }
  template <class Place>
  void take_of_joint(std::string_view, std::size_t, Place) {}  // of the trace, or of a body

  const CsvColumns& table_;
  Trace trace_;
  bool found_ = false;
};

bool is_number(std::string_view text, std::size_t digits) {
  return text.size() >= digits && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// Whether what follows the name in a file's header is what the place makes it. Of a cell that begins with the name of
/// a body or a joint, what follows that.
struct Follows {
  std::string_view rest;
  bool named;

  bool operator()(Column Trace::*) const { return !named && rest.empty(); }
  bool operator()(Column (*)(const Trace&)) const { return !named && rest.empty(); }
  bool operator()(std::vector<Column> Trace::*) const { return named ? rest.empty() : is_number(rest, 1); }
  bool operator()(std::array<Column, 3> BodyColumns::*) const {
    if (rest.empty() || rest[0] < 'x' || rest[0] > 'z') return false;
    return named ? rest.size() == 1 : is_number(rest.substr(1), 1);
  }
  bool operator()(std::array<Column, 9> BodyColumns::*) const {
    return named ? rest.size() == 2 && is_number(rest, 2) : is_number(rest, 3);
  }
  bool operator()(Column JointColumns::*) const { return named && rest.empty(); }
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
  std::string_view cell = line.substr(0, comma);
  line.remove_prefix(more ? comma + 1 : line.size());
  cell.remove_prefix(std::min(cell.find_first_not_of(' '), cell.size()));
  return cell.substr(0, cell.find_last_not_of(' ') + 1);
}

}  // namespace

const TraceColumn* trace_column_of(std::string_view cell) {
  const std::size_t dot = cell.rfind('.');
  const bool named = dot != std::string_view::npos;
  if (named) cell.remove_prefix(dot + 1);
  // A joint has a q of its own, which a body has not: the last row of a name is that of joints.
  const TraceColumn* found = nullptr;
  for (const TraceColumn& row : trace_columns) {
    if (!cell.starts_with(row.name)) continue;
    if (std::visit(Follows{cell.substr(row.name.size()), named}, row.place)) found = &row;
  }
  return found;
}

void put_trace_csv(const Trace& trace, const std::function<void(std::string_view)>& put) {
  const Layout layout(trace);
  std::vector<char> line(layout.columns().size() * (longest_number + 1) + 1);

  put(layout.header() + '\n');
  for (std::size_t k = 0; k < trace.rows(); ++k) {
    char* end = line.data();
    for (const double* column : layout.columns()) {
      if (end != line.data()) *end++ = ',';
      end = put_number(end, column[k]);
    }
    *end++ = '\n';
    put({line.data(), end});
  }
}

std::string trace_csv(const Trace& trace) {
  std::string text;
  put_trace_csv(trace, [&](std::string_view line) { text += line; });
  return text;
}

Trace trace_of(const CsvColumns& table) { return Unlayout(table).trace(); }

namespace {

bool names_nothing(const std::string& cell) {
  double value = 0;
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return stop == cell.data() + cell.size() && error != std::errc::invalid_argument;
}

std::vector<std::string> parse_header(std::string_view line, const std::string& name) {
  std::vector<std::string> header;
  for (bool more = true; more;) header.emplace_back(next_cell(line, more));
  if (std::ranges::all_of(header, names_nothing)) {
    throw UserError(
        fmt::format("{}:1: has no header: must have the names of the columns, not {}", name, header.front()));
  }
  for (const std::string& cell : header) {
    if (cell.empty()) {
      throw UserError(fmt::format("{}:1: column {} has no name", name, &cell - header.data() + 1));
    }
    if (std::ranges::count(header, cell) > 1) throw UserError(fmt::format("{}:1: has two columns {}", name, cell));
  }
  for (const char other : {';', '\t'}) {
    if (header.size() > 1 || header.front().find(other) == std::string::npos) continue;
    throw UserError(
        fmt::format("{}:1: columns must be parted by commas, not by {}", name, other == ';' ? "';'" : "tabs"));
  }
  return header;
}

template <class Where>
double parse_cell(std::string_view cell, const Where& where) {
  double value = 0;
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool whole = stop == cell.data() + cell.size();
  if (whole && error == std::errc::result_out_of_range) {
    throw UserError(fmt::format("{}: '{}' is no number that a double can hold", where(), cell));
  }
  if (!whole || error != std::errc()) throw UserError(fmt::format("{}: '{}' is no number", where(), cell));
  return value;
}

}  // namespace

CsvColumns parse_csv(std::string_view text, const std::string& name) {
  CsvColumns table;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // with which some programs begin a file of UTF-8
  text = text.substr(0, text.find_last_not_of("\r\n") + 1);
  if (text.empty()) return table;
  table.header = parse_header(next_line(text), name);
  table.columns.resize(table.header.size());
  for (long number = 2; !text.empty(); ++number) {
    std::string_view line = next_line(text);
    if (line.empty()) throw UserError(fmt::format("{}:{}: is empty", name, number));
    bool more = true;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      if (!more) throw UserError(fmt::format("{}:{}: has fewer cells than the header", name, number));
      const std::string_view cell = next_cell(line, more);
      const auto where = [&] { return fmt::format("{}:{}: {}", name, number, table.header[i]); };
      table.columns[i].push_back(parse_cell(cell, where));
    }
    if (more) throw UserError(fmt::format("{}:{}: has more cells than the header", name, number));
  }
  return table;
}

CsvColumns read_csv(const std::filesystem::path& file) { return parse_csv(read_whole(file), file.string()); }

}  // namespace odeval
