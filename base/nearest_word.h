// "Did you mean": the nearest of a list of known words.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrobench {

// Insertions, deletions and replacements of one letter, and swaps of two neighbours, that turn `a`
// into `b`.
int EditDistance(std::string_view a, std::string_view b);

// `did you mean "gear_ratio"?` with the nearest of `known` (the first of equals); where none is
// near also the whole list: `did you mean "bus"? (known here: "bus", "unit")`.
std::string Suggestion(std::string_view word, const std::vector<std::string>& known);

}  // namespace gyrobench
