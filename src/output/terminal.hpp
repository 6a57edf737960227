#pragma once
// Colours of what is printed on a terminal. Files and pipes never have any.
#include <string>

namespace odeval {

/// Whether what a file descriptor leads to is a terminal that wants colours: not where NO_COLOR is set, or TERM says
/// that it knows none.
bool wants_colours(int descriptor);

/// Tables are coloured from now on, or not: they are not at first. For standard output alone, once, by the program.
void colour_tables(bool on);

/// The text as it stands in a table or above one: as it is without colours.
std::string bold(const std::string& text);
std::string red(const std::string& text);
std::string green(const std::string& text);

}  // namespace odeval
