#pragma once
// Two folders of results beside each other, file by file.
//
// What two values may differ by and still be the same:
//
// - an error against the reference: the sum of both sides' stated uncertainty at the same time, since neither is known
//   better; likewise q and error_q in a trace, with the uncertainty at the next time for which one is stated
// - an uncertainty: a factor of two, since it is made from differences of two runs, that is, from rounding
// - divergence_time: a spacing of rows, since an error that is off by its uncertainty passes 0.1 rad near that
// - any other measured number: 1e-9 of its size, or of 1 in SI units; a double rounds at 1e-16 and the double pendulum
//   makes that grow by 1e6 in 10 s, the rest is a margin
// - settings, counts, words, the table of a sweep: nothing
//
// reference_lost_at follows from the bound and is not judged. Versions and the reference's description are not judged
// but shown. summary.csv says what METHOD.json says and is judged with it.
#include <filesystem>
#include <string>
#include <vector>

namespace odeval {

struct Difference {
  std::string scenario;  // empty for a file outside of a scenario's folder
  std::string method;    // or the file's name
  std::string metric;    // key in the summary, column and time in a trace
  std::string a;
  std::string b;
  std::string allowed;  // "1.2e-09", or "equal"
};

enum class Sameness {
  bytes,
  within,        // what differs lies within what is allowed
  shown,         // tables of the report, where CPU times stand among the numbers: shown, not judged
  different,     // or there is no such file on one side
  not_compared,  // timings
};

struct FileComparison {
  std::string file;  // from the folder on
  Sameness sameness = Sameness::bytes;
  std::string why;                      // one line
  std::vector<Difference> differences;  // those that count, or are shown
};

struct VersionDifference {
  std::string name;
  std::string a;
  std::string b;
};

struct Comparison {
  std::vector<VersionDifference> versions;
  std::vector<FileComparison> files;  // by name

  bool different() const;
};

/// Throws UserError when a folder is missing or holds no results.
Comparison compare_folders(const std::filesystem::path& a, const std::filesystem::path& b);

/// What made the results of a folder, by its name in the summaries ("ode_double"); several where runs of several builds
/// lie together. Throws UserError as compare_folders does.
std::string version_of(const std::filesystem::path& folder, const std::string& name);

/// "same bytes", "DIFFERENT"
std::string text_of(Sameness sameness);

/// The files, and the first `most` differences.
std::string comparison_table(const Comparison& comparison, std::size_t most = 12);
std::string comparison_json(const Comparison& comparison);

}  // namespace odeval
