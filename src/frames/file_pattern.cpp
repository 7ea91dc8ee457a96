#include "frames/file_pattern.h"

#include "error.h"

#include <filesystem>

namespace kagero {
namespace {

/// A place for a number in a text: its position, its length, and the width of the number.
struct NumberPlace {
    std::size_t position = std::string::npos, length = 0;
    std::size_t width = 0;
    char fill = ' ';
};

/// Finds the next place for a number; `position` of the result is npos if there is none. Sets `is_valid` to false if a
/// percent sign has another meaning.
NumberPlace next_place(const std::string& text, std::size_t begin, bool& is_valid) {
    NumberPlace place;
    for (std::size_t i = text.find('%', begin); i != std::string::npos; i = text.find('%', i + 2)) {
        if (text.compare(i, 2, "%%") == 0) continue;
        std::size_t next = i + 1;
        if (next < text.size() && text[next] == '0') {
            place.fill = '0';
            ++next;
        }
        if (next < text.size() && text[next] >= '1' && text[next] <= '9') place.width = std::size_t(text[next++] - '0');
        if (next < text.size() && text[next] == 'd') {
            place.position = i;
            place.length = next + 1 - i;
            return place;
        }
        is_valid = false;
        return {};
    }
    return {};
}

/// Replaces `%%` by a percent sign.
std::string without_escapes(const std::string& text) {
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        plain += text[i];
        if (text[i] == '%') ++i;
    }
    return plain;
}

}  // namespace

FilePattern::FilePattern(const std::string& path) {
    const std::string remedy = "; write one %d or %04d in the name of the file, such as name-%04d.exr";
    bool is_valid = true;
    const NumberPlace place = next_place(path, 0, is_valid);
    if (!is_valid)
        throw InputError("-o: a % in '" + path + "' is not followed by d, by a width and d, or by another %" + remedy);
    if (place.position == std::string::npos)
        throw InputError("-o: '" + path +
                         "' has no place for the number of the frame, so that all frames would have "
                         "the same name" +
                         remedy);
    const std::size_t end = place.position + place.length;
    if (next_place(path, end, is_valid).position != std::string::npos || !is_valid)
        throw InputError("-o: '" + path + "' has more than one place for the number of the frame" + remedy);
    if (path.find('/', end) != std::string::npos)
        throw InputError("-o: the number of the frame is in the name of a directory in '" + path + "'" + remedy);
    before_ = without_escapes(path.substr(0, place.position));
    after_ = without_escapes(path.substr(end));
    width_ = place.width;
    fill_ = place.fill;
}

std::string FilePattern::file(std::uint32_t frame) const {
    std::string number = std::to_string(frame);
    if (number.size() < width_) number.insert(0, width_ - number.size(), fill_);
    return before_ + number + after_;
}

std::string FilePattern::manifest() const {
    return std::filesystem::path(before_ + "frames" + after_).replace_extension(".json").string();
}

bool has_frame_number(const std::string& path) {
    bool is_valid = true;
    return next_place(path, 0, is_valid).position != std::string::npos;
}

}  // namespace kagero
