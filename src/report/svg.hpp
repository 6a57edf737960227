#pragma once
// gnuplot's SVG made part of a page.
#include <string>
#include <string_view>

namespace odeval::report {

inline constexpr int svg_width = 480;  // units; with the font's size what makes text readable on a phone
inline constexpr int svg_font_size = 14;

// Colours in gnuplot's scripts stand for variables of the style sheet: 0 and up for --c0, --c1, ..., and
inline constexpr int svg_ink = -1;    // the text's own colour
inline constexpr int svg_grid = -2;   // --grid
inline constexpr int svg_shade = -3;  // --shade

/// "#000010", as a script spells it.
std::string svg_colour_code(int colour);

/// The <svg> element for inside a page: coded colours are variables, black is the text's colour, the font is the
/// page's, ids begin with `id`, and `description` is what a screen reader says. Throws MachineError when it is no SVG.
std::string page_svg(std::string_view gnuplots, const std::string& id, const std::string& description);

}  // namespace odeval::report
