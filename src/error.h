/// The errors of the program, and words for their messages.
#pragma once

#include <kagero/error.h>

#include <string>
#include <vector>

namespace kagero {

/// Damerau–Levenshtein distance (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The entry of `known` closest to `word`, or "" when none is near (distance ≤ max(1, length/3)).
std::string near_match(const std::string& word, const std::vector<std::string>& known);

/// Adds to a list as sentences have them: "a, b, c".
void enumerate(std::string& list, const std::string& next);

}  // namespace kagero
