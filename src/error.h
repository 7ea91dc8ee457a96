/// The errors of the program: what was read, where, what was expected, what to do; or what failed while running.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace kagero {

/// A place in a text file; line and column count from 1, 0 where unknown.
struct Place {
    std::string file;
    int line = 0;
    int column = 0;
};

/// Wrong input: command line, scene or data. Becomes exit status 2.
struct InputError : std::runtime_error {
    InputError(const Place& place, const std::string& message);
    explicit InputError(const std::string& message) : std::runtime_error(message) {}
};

/// Something failed while running. Becomes exit status 1.
struct RunError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Told to stop before there was anything to report. Becomes exit status 130.
struct Interrupted : std::exception {
    const char* what() const noexcept override { return "interrupted before there was anything to report"; }
};

/// Damerau–Levenshtein distance (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b);

/// The entry of `known` closest to `word`, or "" when none is near (distance ≤ max(1, length/3)).
std::string near_match(const std::string& word, const std::vector<std::string>& known);

/// Adds to a list as sentences have them: "a, b, c".
void enumerate(std::string& list, const std::string& next);

}  // namespace kagero
