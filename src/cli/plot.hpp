#pragma once
// Columns of traces as a picture, as `odeval plot` and `odeval run --plot` draw it.
#include <filesystem>
#include <string>
#include <vector>

#include "output/trace_csv.hpp"

namespace odeval::cli {

/// A trace to draw.
struct DrawnTrace {
  std::string file;   // for messages
  std::string label;  // in the legend
  CsvColumns table;
};

struct PlotRequest {
  std::vector<std::string> columns;  // a panel each; "q1+q2" are two in one panel
  std::string x = "t";
  std::string minus = {};  // what was taken off, for labels; empty: nothing
  bool log_y = false;
  std::string title = {};
  int width = 1200;
  int height = 0;  // 0: as the panels need
};

/// Returns a line a panel that leaves values out. Throws UserError where a trace lacks a column, MachineError without
/// gnuplot.
std::vector<std::string> draw_traces(const std::vector<DrawnTrace>& traces, const PlotRequest& request,
                                     const std::filesystem::path& file);

/// Columns that share a panel: "q1+q2".
std::vector<std::string> columns_of(const std::string& panel);

/// Whether the file's name says that it is a picture that can be drawn.
bool is_picture(const std::filesystem::path& file);

}  // namespace odeval::cli
