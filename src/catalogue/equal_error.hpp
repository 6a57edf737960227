#pragma once
// What an error costs: each method at its cheapest setting that keeps it, timed.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "catalogue/accuracy.hpp"
#include "catalogue/settings_search.hpp"
#include "output/timing.hpp"

namespace odeval::catalogue {

struct EqualError {
  double max_error;                   // rad; above accuracy.uncertainty()
  int repeats = 5;                    // timed rounds
  long most_steps_tried = 4'000'000;  // of one run of the search
};

/// One row a method, in their order. `begins` is called before each search and each round with what it is.
std::vector<EqualErrorRow> at_equal_error(const Accuracy& accuracy, const std::string& scenario,
                                          std::span<const Method* const> methods, const EqualError& wanted,
                                          const std::function<void(const std::string& what)>& begins = {});

/// The same by a search that knows the error as its one target, and looks at every step instead of rows of its own.
std::vector<EqualErrorRow> at_equal_error(SettingsSearch& search, std::span<const Method* const> methods,
                                          const EqualError& wanted,
                                          const std::function<void(const std::string& what)>& begins = {});

}  // namespace odeval::catalogue
