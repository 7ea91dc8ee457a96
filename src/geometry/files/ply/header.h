/// Header of PLY files: the format, and the elements with their properties.
#pragma once

#include "geometry/files/mesh_file.h"

namespace kagero {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64, none };

enum class PlyFormat { ascii, little_endian, big_endian };

/// Declaration of a property of an element: a number, or a list of numbers after their count.
struct PlyProperty {
    std::string name;
    PlyType type = PlyType::none;
    PlyType count_type = PlyType::none;  ///< Type of a list's length; `none` if the property is not a list.

    bool is_list() const { return count_type != PlyType::none; }
};

/// Declaration of the elements of one kind, such as "vertex" or "face".
struct PlyElement {
    std::string name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties;
};

/// The header, and the position of the data after it.
struct PlyHeader {
    PlyFormat format = PlyFormat::ascii;
    std::vector<PlyElement> elements;
    std::size_t lines = 0;                     ///< Number of lines of the header.
    std::size_t size = 0;                      ///< Number of bytes of the header.
    char line_end = '\n';                      ///< Last letter of a line end: LF, or CR if the file contains CR alone.
    std::vector<std::size_t> unknown_lines{};  ///< Lines that are neither declarations nor comments.
};

/// Returns the number of bytes of a number in a binary file; 0 for `none`.
std::size_t size_of(PlyType type);

/// Returns the position of the first property of this name in an element, or −1.
std::ptrdiff_t find_property(const PlyElement& element, std::string_view name);

/// Refuses a PLY file because of the given line.
[[noreturn]] void refuse_ply(const MeshSource& source, std::size_t line, const std::string& reason);

/// Removes the first line from a text and returns it without its line end.
std::string_view take_line(std::string_view& text, char line_end);

/// Divides a line into words.
std::vector<std::string_view> words_of(std::string_view line);

/// Returns true if the file begins with "ply", in upper or lower case.
bool is_ply(const MeshSource& source);

/// Reads the header. Throws InputError, with the line, if it is invalid.
PlyHeader read_ply_header(const MeshSource& source);

}  // namespace kagero
