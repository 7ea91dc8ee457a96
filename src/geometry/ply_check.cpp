#include "geometry/ply_check.h"

#include "error.h"

#include <algorithm>
#include <cstdint>
#include <strings.h>
#include <fstream>
#include <sstream>

namespace kagero {

namespace {

/// Declaration of a property of an element in the header.
struct Property {
    std::string name;
    std::size_t size = 0;        ///< Bytes of the value, or of each entry of a list.
    std::size_t count_size = 0;  ///< Bytes of a list's length; 0 if the property is not a list.
};

/// Declaration of the elements of one kind, such as "vertex" or "face", in the header.
struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

enum class PlyFormat { ascii, little_endian, big_endian };

/// Header of a PLY file, and the number of lines that have been read.
struct Ply {
    std::string path;
    PlyFormat format = PlyFormat::ascii;
    std::vector<Element> elements;
    int lines = 0;  ///< Number of lines read so far.
};

/// Returns the size in bytes of a PLY type; 0 if the type is not known.
std::size_t size_of(const std::string& type) {
    static const std::pair<const char*, std::size_t> sizes[] = {{"char", 1},   {"uchar", 1},   {"int8", 1},
                                                                {"uint8", 1},  {"short", 2},   {"ushort", 2},
                                                                {"int16", 2},  {"uint16", 2},  {"int", 4},
                                                                {"uint", 4},   {"int32", 4},   {"uint32", 4},
                                                                {"float", 4},  {"float32", 4}, {"double", 8},
                                                                {"float64", 8}};
    for (const auto& [name, size] : sizes) {
        if (type == name) return size;
    }
    return 0;
}

[[noreturn]] void refuse(const Ply& ply, const std::string& message) {
    throw InputError({ply.path, ply.lines, 0}, message);
}

PlyFormat format_of(const std::string& word, const Ply& ply) {
    if (word == "ascii") return PlyFormat::ascii;
    if (word == "binary_little_endian") return PlyFormat::little_endian;
    if (word == "binary_big_endian") return PlyFormat::big_endian;
    refuse(ply, "PLY: format " + word +
                    " is not known; legal formats are ascii, binary_little_endian and "
                    "binary_big_endian");
}

/// Reads one line without its line end, and counts it. Returns false at the end of the file.
bool next_line(std::istream& file, Ply& ply, std::string& line) {
    if (!std::getline(file, line)) return false;
    ++ply.lines;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
}

void read_property(std::istringstream& words, Ply& ply) {
    if (ply.elements.empty())
        refuse(ply, "PLY: a property precedes the first element; an element line must come first");
    Property property;
    std::string type, count_type;
    words >> type;
    if (type == "list") {
        words >> count_type >> type;
        property.count_size = size_of(count_type);
        if (property.count_size == 0)
            refuse(ply, "PLY: type " + count_type +
                            " of a list's length is not known; legal types are char, uchar, "
                            "short, ushort, int and uint");
    }
    words >> property.name;
    property.size = size_of(type);
    if (property.size == 0)
        refuse(ply, "PLY: type " + type +
                        " is not known; legal types are char, uchar, short, ushort, int, uint, float, "
                        "double, and int8 to float64");
    ply.elements.back().properties.push_back(property);
}

void read_header(std::istream& file, Ply& ply) {
    std::string line;
    while (next_line(file, ply, line)) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "end_header") return;
        if (word == "format") {
            words >> word;
            ply.format = format_of(word, ply);
        } else if (word == "element") {
            Element element;
            if (!(words >> element.name >> element.count))
                refuse(ply, "PLY: an element line must have the form: element NAME COUNT");
            ply.elements.push_back(element);
        } else if (word == "property") {
            read_property(words, ply);
        }
    }
    refuse(ply, "PLY: the file ends inside the header; the line end_header is missing");
}

[[noreturn]] void refuse_truncated(const Ply& ply, const Element& element, std::uint64_t found) {
    refuse(ply, "PLY: the header declares " + std::to_string(element.count) + " elements \"" + element.name +
                    "\", but the file ends after " + std::to_string(found) + " complete ones");
}

/// Checks one element of a text file. An element occupies one line.
void check_text_element(const Ply& ply, const Element& element, const std::string& line) {
    if (std::any_of(line.begin(), line.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' && c != '\t'; }))
        refuse(ply, "PLY: the line of an element \"" + element.name + "\" contains a control character");
    std::istringstream words(line);
    std::uint64_t expected = 0, found = 0;
    std::string word;
    for (const Property& property : element.properties) {
        std::uint64_t count = 1;
        if (property.count_size > 0) {
            ++expected;
            if (!(words >> count)) break;
            if (count > line.size())
                refuse(ply, "PLY: a list of an element \"" + element.name +
                                "\" declares more entries than its line has characters");
            ++found;
        }
        expected += count;
        for (std::uint64_t i = 0; i < count && words >> word; ++i) ++found;
    }
    while (words >> word) ++found;
    if (found == expected) return;
    refuse(ply, "PLY: expected " + std::to_string(expected) + " numbers for an element \"" + element.name + "\", got " +
                    std::to_string(found));
}

void check_text(std::istream& file, Ply& ply) {
    std::string line;
    const auto next_nonblank = [&] {
        while (next_line(file, ply, line)) {
            if (line.find_first_not_of(" \t") != std::string::npos) return true;
        }
        return false;
    };
    for (const Element& element : ply.elements) {
        for (std::uint64_t i = 0; i < element.count; ++i) {
            if (!next_nonblank()) refuse_truncated(ply, element, i);
            check_text_element(ply, element, line);
        }
    }
    if (next_nonblank())
        refuse(ply, "PLY: the file contains more data after the last element that its header declares");
}

/// Decodes an unsigned integer of `size` bytes: the number of entries of a list.
std::uint64_t read_count(const char* bytes, std::size_t size, bool big_endian) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
        value = value << 8 | static_cast<unsigned char>(bytes[big_endian ? i : size - 1 - i]);
    }
    return value;
}

/// Returns the size in bytes of the binary element at `bytes`. Returns more than `left`, the number of remaining bytes,
/// if the file ends within the element.
std::size_t binary_size(const Element& element, const char* bytes, std::size_t left, bool big_endian) {
    std::size_t size = 0;
    for (const Property& property : element.properties) {
        std::uint64_t count = 1;
        if (property.count_size > 0) {
            if (size + property.count_size > left) return left + 1;
            count = read_count(bytes + size, property.count_size, big_endian);
            size += property.count_size;
        }
        if (count > (left - std::min(left, size)) / property.size) return left + 1;
        size += static_cast<std::size_t>(count) * property.size;
    }
    return size;
}

void check_binary(std::istream& file, Ply& ply) {
    const std::string body{std::istreambuf_iterator<char>(file), {}};
    ply.lines = 0;  // errors in binary data are reported without a line number
    std::size_t offset = 0;
    for (const Element& element : ply.elements) {
        for (std::uint64_t i = 0; i < element.count; ++i) {
            const std::size_t size =
                binary_size(element, body.data() + offset, body.size() - offset, ply.format == PlyFormat::big_endian);
            if (size > body.size() - offset) refuse_truncated(ply, element, i);
            if (size == 0) break;  // all elements without properties occupy no bytes
            offset += size;
        }
    }
    if (body.find_first_not_of(" \t\r\n", offset) != std::string::npos) {
        refuse(ply, "PLY: the file contains more data after the last element that its header declares");
    }
}

}  // namespace

bool is_ply(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    char start[4] = {};
    return file.read(start, 3) && strcasecmp(start, "ply") == 0;  // the test that assimp uses
}

void check_ply(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    Ply ply{path, {}, {}, 0};
    read_header(file, ply);
    if (ply.format == PlyFormat::ascii)
        check_text(file, ply);
    else
        check_binary(file, ply);
}

}  // namespace kagero
