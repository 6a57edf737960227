#pragma once
// What elements an XML file has, before a library reads it that passes over those it does not know.
#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace odeval {

/// How often each path of elements stands in the text: "robot/link/visual".
///
/// Throws UserError, which begins with the file's name and the line, for a document type (whose entities can grow
/// without bounds), for elements that do not close one another and for more than 100 within one another (which the
/// libraries' recursion does not stand).
std::map<std::string, std::size_t> xml_outline(const std::string& file, std::string_view text);

}  // namespace odeval
