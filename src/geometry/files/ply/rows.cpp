#include "geometry/files/ply/rows.h"

#include <algorithm>
#include <bit>

namespace kagero {

namespace {

template <class Integer>
double from_integer(std::uint64_t bits) {
    return static_cast<double>(static_cast<Integer>(bits));
}

/// Returns the number of a type that is stored in the low bits.
double decoded(PlyType type, std::uint64_t bits) {
    switch (type) {
        case PlyType::int8: return from_integer<std::int8_t>(bits);
        case PlyType::uint8: return from_integer<std::uint8_t>(bits);
        case PlyType::int16: return from_integer<std::int16_t>(bits);
        case PlyType::uint16: return from_integer<std::uint16_t>(bits);
        case PlyType::int32: return from_integer<std::int32_t>(bits);
        case PlyType::uint32: return from_integer<std::uint32_t>(bits);
        case PlyType::float32: return double(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
        case PlyType::float64: return std::bit_cast<double>(bits);
        case PlyType::none: break;
    }
    return 0;
}

}  // namespace

PlyRows::PlyRows(const MeshSource& source, const PlyHeader& header)
    : source_(source), header_(header), rest_(source.bytes), line_(header.lines) {
    rest_.remove_prefix(header.size);
    if (header.format != PlyFormat::ascii) line_ = 0;
}

void PlyRows::refuse_end(const PlyElement& element, std::uint64_t index) const {
    refuse_ply(source_, line_,
               "the header declares " + std::to_string(element.count) + " elements " + in_quotes(element.name) +
                   ", but the file ends after " + std::to_string(index) + " complete ones");
}

bool PlyRows::next_line_with_words(std::string_view& line) {
    while (!rest_.empty()) {
        line = take_line(rest_, header_.line_end);
        ++line_;
        if (line.find_first_not_of(" \t") != std::string_view::npos) return true;
    }
    return false;
}

std::size_t PlyRows::list_length(const PlyElement& element, double length, std::size_t most) const {
    if (length >= 0 && length <= double(most) && length == std::floor(length)) return static_cast<std::size_t>(length);
    const bool is_text = header_.format == PlyFormat::ascii;
    refuse_ply(source_, line_,
               "a list of an element " + in_quotes(element.name) + " declares more entries than " +
                   (is_text ? "its line has characters" : "the file has left") +
                   ", or its length is not a whole number >= 0: " + number_text(length));
}

void PlyRows::check_number_of_words(const PlyElement& element, const std::vector<std::string_view>& words) const {
    std::size_t expected = 0;
    for (const PlyProperty& property : element.properties) {
        double length = 1;
        if (property.is_list()) {
            if (expected >= words.size() || !parse_number(words[expected], length)) length = 0;
            length = double(list_length(element, length, source_.bytes.size()));
            ++expected;
        }
        expected += static_cast<std::size_t>(length);
    }
    if (words.size() != expected)
        refuse_ply(source_, line_,
                   "expected " + std::to_string(expected) + " numbers for an element " + in_quotes(element.name) +
                       ", got " + std::to_string(words.size()));
}

void PlyRows::read_text(const PlyElement& element, std::uint64_t index, PlyRow& row) {
    std::string_view line;
    if (!next_line_with_words(line)) refuse_end(element, index);
    if (std::any_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t'; }))
        refuse_ply(source_, line_,
                   "the line of an element " + in_quotes(element.name) + " contains a control character");
    row.line = line_;
    const std::vector<std::string_view> words = words_of(line);
    std::vector<double> numbers(words.size());
    for (std::size_t i = 0; i < words.size(); ++i)
        if (!parse_number(words[i], numbers[i])) refuse_ply(source_, line_, in_quotes(words[i]) + " is not a number");
    std::size_t next = 0;
    for (const PlyProperty& property : element.properties) {
        std::size_t count = 1;
        if (property.is_list()) {
            if (next >= words.size()) break;
            count = list_length(element, numbers[next++], line.size());
        }
        for (; count > 0 && next < words.size(); --count) row.numbers.push_back(numbers[next++]);
        if (count > 0) break;
        row.starts.push_back(row.numbers.size());
    }
    if (row.starts.size() <= element.properties.size() || next < words.size()) check_number_of_words(element, words);
}

double PlyRows::take_number(PlyType type) {
    const std::size_t size = size_of(type);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i)
        bits =
            bits << 8 | static_cast<unsigned char>(rest_[header_.format == PlyFormat::big_endian ? i : size - 1 - i]);
    rest_.remove_prefix(size);
    return decoded(type, bits);
}

void PlyRows::read_binary(const PlyElement& element, std::uint64_t index, PlyRow& row) {
    for (const PlyProperty& property : element.properties) {
        std::size_t count = 1;
        if (property.is_list()) {
            if (rest_.size() < size_of(property.count_type)) refuse_end(element, index);
            const double length = take_number(property.count_type);
            count = list_length(element, length, length < 0 ? 0 : std::size_t{1} << 32);
        }
        if (count > rest_.size() / size_of(property.type)) refuse_end(element, index);
        for (; count > 0; --count) row.numbers.push_back(take_number(property.type));
        row.starts.push_back(row.numbers.size());
    }
}

void PlyRows::read(const PlyElement& element, std::uint64_t index, PlyRow& row) {
    row.numbers.clear();
    row.starts.assign(1, 0);
    row.line = 0;
    if (header_.format == PlyFormat::ascii) read_text(element, index, row);
    else read_binary(element, index, row);
}

void PlyRows::check_end() {
    std::string_view line;
    const bool is_text = header_.format == PlyFormat::ascii;
    const bool has_more = is_text ? next_line_with_words(line) : rest_.find_first_not_of(" \t\r\n") != rest_.npos;
    if (has_more)
        refuse_ply(source_, line_, "the file contains more data after the last element that its header declares");
}

}  // namespace kagero
