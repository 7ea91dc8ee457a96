/// Names of the files of frames.
#pragma once

#include <cstdint>
#include <string>

namespace kagero {

/// A path with a place for the number of the frame, such as "out/name-%04d.exr".
class FilePattern {
public:
    /// Throws InputError unless the name of the file contains exactly one of %d, %2d … %9d or %02d … %09d. `%%` is a
    /// percent sign.
    explicit FilePattern(const std::string& path);
    /// Returns the path of a frame, such as "out/name-0017.exr".
    std::string file(std::uint32_t frame) const;
    /// Returns the path of the manifest: that of the frames with the word "frames" instead of the number, and the
    /// extension .json, such as "out/name-frames.json".
    std::string manifest() const;

private:
    std::string before_, after_;
    std::size_t width_ = 0;  ///< Least number of digits.
    char fill_ = '0';        ///< Character in front of shorter numbers.
};

/// Returns true if the path contains a place for a number.
bool has_frame_number(const std::string& path);

}  // namespace kagero
