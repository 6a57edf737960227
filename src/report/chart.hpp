#pragma once
// Panels one above the other as a picture of their own.
#include <string>
#include <vector>

#include "report/document.hpp"

namespace odeval::report {

struct Chart {
  std::string title;
  std::vector<Panel> panels;  // of one x axis; each series a line, by its colour the same in all panels; titles small
  int width = 1200;           // pixels
  int height = 800;
};

enum class ChartFormat { svg, png };

/// On white, by gnuplot. Where a line has more points than pixels could show, only the lowest and the highest of each
/// few are drawn. Same chart, same bytes. Throws MachineError as `run_gnuplot`.
std::string drawn(const Chart& chart, ChartFormat format);

}  // namespace odeval::report
