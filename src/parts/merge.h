/// Merging of parts to a picture.
#pragma once

#include "parts/tile_file.h"

namespace kagero {

/// Conditions under which a picture may be merged: with all parts, or with those that exist.
enum class Missing { refused, allowed };

/// A picture that was read from its parts.
struct MergedPicture {
    TileFileHeader header;  ///< That of the first file.
    Film film;
    RunReport report;  ///< Sums over all tiles. `interrupted` is true if tiles are missing.
    std::vector<std::uint32_t> missing_parts;
    std::uint64_t missing_tiles = 0;
    std::vector<std::string> remarks;  ///< Statements about what is missing, one line each.

    /// Returns the attributes of the picture file.
    Metadata metadata() const;
};

/// Reads the headers of parts, and returns the first one. Throws InputError unless the parts belong to the same picture
/// and none of them is given twice, or missing if `missing` is `refused`.
TileFileHeader check_parts(const std::vector<std::string>& files, Missing missing);

/// Reads parts that check_parts accepts. Throws InputError if a file is incomplete or damaged. If `missing` is
/// `allowed`, the complete tiles of such a file are used, and pixels that no file contains are black.
MergedPicture merge_parts(const std::vector<std::string>& files, Missing missing);

}  // namespace kagero
