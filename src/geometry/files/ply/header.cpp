#include "geometry/files/ply/header.h"

#include <strings.h>

#include <algorithm>
#include <charconv>

namespace kagero {

namespace {

struct TypeName {
    const char* word;
    PlyType type;
};

constexpr TypeName type_names[] = {
    {"char", PlyType::int8},       {"uchar", PlyType::uint8},    {"short", PlyType::int16},
    {"ushort", PlyType::uint16},   {"int", PlyType::int32},      {"uint", PlyType::uint32},
    {"float", PlyType::float32},   {"double", PlyType::float64}, {"int8", PlyType::int8},
    {"uint8", PlyType::uint8},     {"int16", PlyType::int16},    {"uint16", PlyType::uint16},
    {"int32", PlyType::int32},     {"uint32", PlyType::uint32},  {"float32", PlyType::float32},
    {"float64", PlyType::float64},
};

const std::vector<std::string> header_words{"format", "comment", "obj_info", "element", "property", "end_header"};

PlyType type_of(std::string_view word) {
    for (const TypeName& name : type_names)
        if (word == name.word) return name.type;
    return PlyType::none;
}

PlyFormat format_of(const MeshSource& source, std::size_t line, const std::vector<std::string_view>& words) {
    const std::string_view word = words.size() > 1 ? words[1] : "";
    if (word == "ascii") return PlyFormat::ascii;
    if (word == "binary_little_endian") return PlyFormat::little_endian;
    if (word == "binary_big_endian") return PlyFormat::big_endian;
    refuse_ply(source, line,
               "format " + std::string(word) +
                   " is not known; legal formats are ascii, binary_little_endian and binary_big_endian");
}

PlyElement element_of(const MeshSource& source, std::size_t line, const std::vector<std::string_view>& words) {
    PlyElement element;
    bool is_legal = words.size() == 3;
    if (is_legal) {
        element.name = words[1];
        const char* end = words[2].data() + words[2].size();
        const auto result = std::from_chars(words[2].data(), end, element.count);
        is_legal = result.ec == std::errc{} && result.ptr == end;
    }
    if (!is_legal)
        refuse_ply(source, line,
                   "an element line must have the form: element NAME COUNT, where COUNT is a whole "
                   "number >= 0");
    return element;
}

PlyProperty property_of(const MeshSource& source, std::size_t line, const std::vector<std::string_view>& words) {
    const bool is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (is_list ? 5u : 3u))
        refuse_ply(source, line,
                   "a property line must have the form: property TYPE NAME, or property list TYPE TYPE "
                   "NAME");
    PlyProperty property{std::string(words.back()), type_of(words[words.size() - 2]), PlyType::none};
    if (property.type == PlyType::none)
        refuse_ply(source, line,
                   "type " + in_quotes(words[words.size() - 2]) +
                       " is not known; legal types are char, uchar, short, ushort, int, uint, float, "
                       "double, and int8 to float64");
    if (!is_list) return property;
    property.count_type = type_of(words[2]);
    if (property.count_type == PlyType::none || property.count_type == PlyType::float32 ||
        property.count_type == PlyType::float64)
        refuse_ply(source, line,
                   "type " + in_quotes(words[2]) +
                       " of a list's length is not legal; legal types are char, uchar, short, ushort, "
                       "int, uint, and int8 to uint32");
    return property;
}

/// Reads a line of the header that declares an element or a property.
void read_declaration(const MeshSource& source, PlyHeader& header, const std::vector<std::string_view>& words) {
    if (words[0] == "element") {
        const PlyElement element = element_of(source, header.lines, words);
        for (const PlyElement& other : header.elements)
            if (other.name == element.name)
                refuse_ply(source, header.lines, "the element " + in_quotes(element.name) + " is declared twice");
        header.elements.push_back(element);
    } else if (words[0] == "property") {
        const PlyProperty property = property_of(source, header.lines, words);
        if (header.elements.empty())
            refuse_ply(source, header.lines, "a property precedes the first element; an element line must come first");
        PlyElement& element = header.elements.back();
        element.properties.push_back(property);
    } else if (words[0] != "comment" && words[0] != "obj_info") {
        const std::string near = near_match(std::string(words[0]), header_words);
        if (!near.empty())
            refuse_ply(source, header.lines,
                       in_quotes(words[0]) + " is not legal in the header; did you mean \"" + near + "\"?");
        header.unknown_lines.push_back(header.lines);  // some programs write comments without the word comment
    }
}

}  // namespace

std::size_t size_of(PlyType type) {
    switch (type) {
        case PlyType::int8:
        case PlyType::uint8: return 1;
        case PlyType::int16:
        case PlyType::uint16: return 2;
        case PlyType::int32:
        case PlyType::uint32:
        case PlyType::float32: return 4;
        case PlyType::float64: return 8;
        case PlyType::none: break;
    }
    return 0;
}

std::ptrdiff_t find_property(const PlyElement& element, std::string_view name) {
    for (std::size_t i = 0; i < element.properties.size(); ++i)
        if (element.properties[i].name == name) return static_cast<std::ptrdiff_t>(i);
    return -1;
}

void refuse_ply(const MeshSource& source, std::size_t line, const std::string& reason) {
    refuse_file(source, line, "PLY: " + reason);
}

std::string_view take_line(std::string_view& text, char line_end) {
    const std::size_t end = std::min(text.find(line_end), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line_end == '\n' && line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    for (std::size_t start = 0; (start = line.find_first_not_of(" \t", start)) != std::string_view::npos;) {
        const std::size_t end = std::min(line.find_first_of(" \t", start), line.size());
        words.push_back(line.substr(start, end - start));
        start = end;
    }
    return words;
}

bool is_ply(const MeshSource& source) {
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";  // editors add it to text
    std::string_view text = source.bytes;
    if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
    return text.size() >= 3 && strncasecmp(text.data(), "ply", 3) == 0;
}

PlyHeader read_ply_header(const MeshSource& source) {
    PlyHeader header;
    std::string_view rest = source.bytes;
    const std::size_t first_end = rest.find_first_of("\r\n");
    if (first_end != std::string_view::npos && rest[first_end] == '\r' && rest.substr(first_end, 2) != "\r\n")
        header.line_end = '\r';
    bool has_format = false;
    while (!rest.empty()) {
        const std::vector<std::string_view> words = words_of(take_line(rest, header.line_end));
        ++header.lines;
        if (header.lines == 1 || words.empty()) continue;
        if (words[0] == "end_header") {
            if (!has_format)
                refuse_ply(source, header.lines, "the header has no format line, for example: format ascii 1.0");
            header.size = source.bytes.size() - rest.size();
            return header;
        }
        if (words[0] == "format") {
            header.format = format_of(source, header.lines, words);
            has_format = true;
        } else {
            read_declaration(source, header, words);
        }
    }
    refuse_ply(source, header.lines, "the file ends inside the header; the line end_header is missing");
}

}  // namespace kagero
