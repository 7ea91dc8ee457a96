/// The exceptions of kagero. A message states the invalid input and its position, or the failed operation, the legal
/// values, and what to do.
#pragma once

#include <kagero/export.h>

#include <stdexcept>
#include <string>

namespace kagero {

/// A position in a text file. Lines and columns are counted from 1; 0 means unknown.
struct FileLocation {
    std::string file;  ///< Name of the file, or the command-line option that contains the input.
    int line = 0;
    int column = 0;
};

/// Thrown if an input is invalid: the command line, a scene or other data. `what()` begins with the location. The
/// program exits with status 2.
struct KAGERO_PUBLIC InputError : std::runtime_error {
    InputError(const FileLocation& location, const std::string& message);
    explicit InputError(const std::string& message) : std::runtime_error(message) {}

    const FileLocation location;  ///< `file` is empty if the location is unknown.
};

/// Thrown if a run fails. The program exits with status 1.
struct KAGERO_PUBLIC RunError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Thrown if a run is interrupted before it has any result. The program exits with status 130.
struct KAGERO_PUBLIC Interrupted : std::exception {
    const char* what() const noexcept override { return "interrupted before there was anything to report"; }
};

}  // namespace kagero
