#include "frames/frame_range.h"

#include "error.h"

#include <algorithm>
#include <charconv>
#include <vector>

namespace kagero {
namespace {

std::uint32_t number_of_range(const std::string& text, const std::string& range) {
    constexpr std::uint64_t greatest = std::uint64_t{1} << 31;
    std::uint64_t number = 0;
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), end, number);
    if (parsed.ec == std::errc::result_out_of_range || (parsed.ec == std::errc{} && number > greatest))
        throw InputError("--frames: " + text + " in '" + range +
                         "' is beyond 2147483648, the greatest number of frames");
    if (text.empty() || parsed.ec != std::errc{} || parsed.ptr != end)
        throw InputError("--frames: '" + range +
                         "' is not a range A:B or A:B:STEP of whole numbers, such as 0:240 or 0:240:10; B itself is "
                         "not part of the range");
    return static_cast<std::uint32_t>(number);
}

}  // namespace

FrameRange frame_range(const std::string& text, std::uint32_t frames) {
    std::vector<std::uint32_t> numbers;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(':', begin), text.size());
        numbers.push_back(number_of_range(text.substr(begin, end - begin), text));
        begin = end + 1;
    }
    if (numbers.size() < 2 || numbers.size() > 3) number_of_range("", text);
    FrameRange range{numbers[0], numbers[1], numbers.size() > 2 ? numbers[2] : 1};
    if (range.step == 0) throw InputError("--frames: the STEP in '" + text + "' is 0; it must be at least 1");
    if (range.first >= range.end)
        throw InputError("--frames: the range '" + text +
                         "' contains no frame, because A must be less than B, and B "
                         "itself is not part of the range");
    if (range.end > frames)
        throw InputError("--frames: the animation has frames 0 to " + std::to_string(frames - 1) + ", so B in '" +
                         text + "' can be at most " + std::to_string(frames) +
                         "; -D animation.frames=N changes their number");
    return range;
}

}  // namespace kagero
