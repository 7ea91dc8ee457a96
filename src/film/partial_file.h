/// Files that appear under their name only when they are complete.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace kagero {

/// Throws InputError when no file can be put at `path`: its directory is missing or closed, a directory bears its name,
/// or no file can bear it.
void check_file_writable(const std::string& path);

/// Calls `write` with a file that appears at `path` when it is complete, and replaces what was there. A path that is
/// not a regular file (a pipe, /dev/null) is written directly. Throws RunError when not all could be written; then what
/// was there stays.
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);
void write_text_file(const std::string& path, const std::string& text);

}  // namespace kagero
