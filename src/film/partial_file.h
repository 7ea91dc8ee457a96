/// Functions that write a file under a temporary name and rename it when it is complete.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace kagero {

/// Throws InputError if no file can be written at `path`: the path is empty or invalid, its folder is missing or not
/// writable, or it is itself a folder.
void check_file_writable(const std::string& path);

/// Writes a file by calling `write` with a stream. The new file replaces an existing file at `path` when it is
/// complete. A path that is not a regular file (a pipe, /dev/null) is written directly. Throws RunError if writing
/// fails; an existing file is then unchanged.
void write_file(const std::string& path, const std::function<void(std::ostream&)>& write);
/// Writes a file with the given text, as write_file does.
void write_text_file(const std::string& path, const std::string& text);

}  // namespace kagero
