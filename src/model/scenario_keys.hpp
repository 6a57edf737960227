#pragma once
// The one table of what a scenario file may say. Reading, checking, messages and help follow it.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/description.hpp"

namespace odeval {

/// The words a scenario file may use for methods and metrics.
struct Names {
  std::vector<std::string> methods;
  std::vector<std::string> metrics;
};

/// A value that has the right type; the member of its kind is filled.
struct KeyValue {
  double number = 0;
  std::vector<double> numbers;
  std::string word;
  std::vector<std::string> words;
};

enum class KeyKind {
  number,
  whole,
  numbers,
  several,  // a number, or a list of them
  word,
  words,
  name,
  names,
};

struct KeyRow {
  std::string_view section;  // "" for the top of the file, or the name of a table
  std::string_view name;
  KeyKind kind;
  std::string_view unit;
  double least;     // of a number, or of each number of a list
  double greatest;  // infinite: `inf` is a value
  bool ends_excluded;
  std::vector<std::string> (*allowed)(const Names&);  // of words; null for all else
  std::string_view fallback;                          // what holds without the key; empty: the key must be there
  std::string_view meaning;
  void (*put)(Description&, Scenario&, const KeyValue&);  // for a list of tables: into its last element
  std::size_t count = 0;                                  // of a list's numbers or names; 0: the problem's own

  bool required() const { return fallback.empty(); }
};

/// A table of the file, or a list of tables; with a dot in its name a table within each of a list.
struct SectionRow {
  std::string_view name;
  bool list;

  bool inner() const { return name.find('.') != std::string_view::npos; }
};

std::span<const KeyRow> key_table();
std::span<const SectionRow> section_table();
/// Their names.
std::vector<std::string> section_names();

/// Null when there is no such key.
const KeyRow* find_key(std::string_view section, std::string_view name);

/// What a right value looks like: "must be a number from 0 to 1 rad".
std::string rule_of(const KeyRow& row, const Names& names);

}  // namespace odeval
