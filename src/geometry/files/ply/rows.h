/// Data of PLY files: the elements, one after the other.
#pragma once

#include "geometry/files/ply/header.h"

namespace kagero {

/// The numbers of one element. Every type of number is converted to `double` without loss.
struct PlyRow {
    std::vector<double> numbers;      ///< The numbers of all properties, without the lengths of lists.
    std::vector<std::size_t> starts;  ///< Start of each property in `numbers`, and the end of the last one.
    std::size_t line = 0;             ///< Line of the element; 0 in binary files.

    double number(std::ptrdiff_t property) const { return numbers[starts[static_cast<std::size_t>(property)]]; }
    const double* list(std::ptrdiff_t property) const {
        return numbers.data() + starts[static_cast<std::size_t>(property)];
    }
    std::size_t size(std::ptrdiff_t property) const {
        const auto i = static_cast<std::size_t>(property);
        return starts[i + 1] - starts[i];
    }
};

/// Reads the elements of a file in the order of the file. All counts are compared with the bytes that are left, so that
/// the memory is of the order of the file's size.
class PlyRows {
public:
    PlyRows(const MeshSource& source, const PlyHeader& header);

    /// Reads the next element, which must be of the declared kind. `index` is its number among the elements of its
    /// kind. Throws InputError, with the line of a text file, if the data is not as declared or ends too early.
    void read(const PlyElement& element, std::uint64_t index, PlyRow& row);

    /// Refuses the file if it contains more data than its header declares.
    void check_end();

private:
    void read_text(const PlyElement& element, std::uint64_t index, PlyRow& row);
    void read_binary(const PlyElement& element, std::uint64_t index, PlyRow& row);
    void check_number_of_words(const PlyElement& element, const std::vector<std::string_view>& words) const;
    std::size_t list_length(const PlyElement& element, double length, std::size_t most) const;
    bool next_line_with_words(std::string_view& line);
    double take_number(PlyType type);
    [[noreturn]] void refuse_end(const PlyElement& element, std::uint64_t index) const;

    const MeshSource& source_;
    const PlyHeader& header_;
    std::string_view rest_;  ///< The data that has not been read.
    std::size_t line_;       ///< Number of lines read so far; 0 in binary files.
};

}  // namespace kagero
