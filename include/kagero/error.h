/// The errors of kagero: what was read, where, what was expected, what to do; or what failed while running.
#pragma once

#include <kagero/export.h>

#include <stdexcept>
#include <string>

namespace kagero {

/// A place in a text file; line and column count from 1, 0 where unknown.
struct Place {
    std::string file;
    int line = 0;
    int column = 0;
};

/// Wrong input: command line, scene or data. `what()` names the place first; the program exits with status 2.
struct KAGERO_PUBLIC InputError : std::runtime_error {
    InputError(const Place& place, const std::string& message);
    explicit InputError(const std::string& message) : std::runtime_error(message) {}

    const Place place;  ///< empty where the input is not a file
};

/// Something failed while running. The program exits with status 1.
struct KAGERO_PUBLIC RunError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Told to stop before there was anything to report. The program exits with status 130.
struct KAGERO_PUBLIC Interrupted : std::exception {
    const char* what() const noexcept override { return "interrupted before there was anything to report"; }
};

}  // namespace kagero
