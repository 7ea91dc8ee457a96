/// Ranges of frames.
#pragma once

#include <cstdint>
#include <string>

namespace kagero {

/// The frames first, first + step, … below `end`.
struct FrameRange {
    std::uint32_t first = 0, end = 1, step = 1;

    std::uint32_t count() const { return (end - first + step - 1) / step; }
    std::uint32_t frame(std::uint32_t index) const { return first + index * step; }
};

/// Parses "A:B" or "A:B:STEP", the value of --frames. Throws InputError unless 0 <= A < B <= `frames`, the number of
/// frames of the animation, and STEP is at least 1.
FrameRange frame_range(const std::string& text, std::uint32_t frames);

}  // namespace kagero
