#pragma once
// Pieces of gnuplot's language that every figure is written in.
#include <array>
#include <cstddef>
#include <string>

#include "report/document.hpp"

namespace odeval::report {

// Of pictures with a file of their own, on white: colours that differ for colour-blind readers as well (Okabe and Ito,
// 2008).
inline constexpr std::array own_colours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7f00"};

/// Text in gnuplot's single quotes, on one line.
std::string quoted(const std::string& text);

/// Whether a value has a place on an axis.
bool drawable(double value, bool log);

/// The points of a series as a data block $dNUMBER; what has no place is a gap.
std::string data_block(const Series& series, const Panel& panel, std::size_t number);

}  // namespace odeval::report
