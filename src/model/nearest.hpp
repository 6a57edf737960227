#pragma once
// The known word nearest to a mistyped one, for error messages.
#include <span>
#include <string>
#include <string_view>

namespace odeval {

/// Letters to insert, delete or replace to turn one word into the other (Levenshtein).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The first of the known words that goes on where this one ends ("ode-step" of "ode-step-double"), or else with the
/// least edit distance; empty when none is known.
std::string nearest(std::string_view word, std::span<const std::string> known);

/// " (nearest: 'word')" where a known word is near enough to be what was meant: it only goes on, or at most half its
/// letters differ.
std::string nearest_hint(std::string_view word, std::span<const std::string> known);

}  // namespace odeval
