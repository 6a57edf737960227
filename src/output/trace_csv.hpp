#pragma once
// A trace as comma-separated columns, and columns back from such a file.
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "odeval/trace.hpp"
#include "output/trace_columns.hpp"

namespace odeval {

/// One header row, one row a sample; columns the trace does not have are left out.
std::string trace_csv(const Trace& trace);

/// The same, line by line: a file of megabytes is never whole in memory.
void put_trace_csv(const Trace& trace, const std::function<void(std::string_view)>& put);

/// The table's row of a cell of that header: "gap", "q2", "vx1", "r1211", "arm.vx", "elbow.q". Null: no trace has such
/// a column.
const TraceColumn* trace_column_of(std::string_view cell);

/// A file of numbers under a header row.
struct CsvColumns {
  std::vector<std::string> header;
  std::vector<Column> columns;  // one per header cell, all of one length
};

/// Throws UserError, naming `name` and the line, when a column has no name or that of another, a row has another number
/// of cells or a cell is no number. Blanks around cells, a byte order mark and empty lines at the end say nothing.
CsvColumns parse_csv(std::string_view text, const std::string& name);

/// The columns that a trace has in files, whichever of them are there; what is made of others (energy) and columns that
/// no trace has are left out.
Trace trace_of(const CsvColumns& table);

/// Throws UserError as `parse_csv`, and when the file cannot be read.
CsvColumns read_csv(const std::filesystem::path& file);

}  // namespace odeval
