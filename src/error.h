/// The errors of the program, and functions for their messages.
#pragma once

#include <kagero/error.h>

#include <string>
#include <vector>

namespace kagero {

/// Returns the Damerau–Levenshtein distance (optimal string alignment) of two words.
std::size_t edit_distance(const std::string& a, const std::string& b);

/// Returns the entry of `known` that is nearest to `word`, or "" if no entry is near. An entry is near if its distance
/// is at most max(1, length/3). For an entry that begins with `word`, the distance is reduced by one.
std::string near_match(const std::string& word, const std::vector<std::string>& known);

/// Appends an item to a list in a sentence: "a, b" becomes "a, b, c".
void append_to_list(std::string& list, const std::string& next);

}  // namespace kagero
