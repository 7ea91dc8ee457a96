/// Tile files: finished tiles of a picture, with all data that the picture file needs. A part of a picture and the
/// journal of a render are tile files.
///
/// A tile file consists of 16 bytes that identify it, the version of the format (32 bits), and records. A record
/// consists of its kind (32 bits), the size of its content (64 bits), the content, and the checksum of all these
/// bytes (64 bits). The first record is the header. Each further record is a tile, in any order. The record `end`
/// completes a part; a journal has none. Numbers are little-endian, floats are IEEE 754.
#pragma once

#include "film/write_film.h"
#include "parts/tile_results.h"
#include "render/schedule.h"

#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kagero {

/// Names and values, in a fixed order.
using Properties = std::vector<std::pair<std::string, std::string>>;

/// Greatest number of parts of a picture.
inline constexpr std::uint32_t max_parts = 100000;

/// One of `count` parts of a picture. It contains the tiles with index % count == number − 1. Neighbouring tiles belong
/// to different parts, so that all parts have similar costs.
struct PartNumber {
    std::uint32_t number = 1, count = 1;

    /// Returns, for example, "2/7".
    std::string text() const { return std::to_string(number) + "/" + std::to_string(count); }
    bool contains(std::uint64_t index) const { return index % count == number - 1; }
    /// Returns the number of tiles of a grid that belong to the part.
    std::uint64_t tiles_of(const TileGrid& grid) const;
};

/// The first record of a tile file.
struct TileFileHeader {
    Properties identity;        ///< What must be the same for all parts, and for a run that continues a journal.
    Properties choices;         ///< What the program has chosen for `auto`, see choices.h.
    Metadata metadata;          ///< Attributes of the picture, except those that its rays determine.
    bool misses_bound = false;  ///< misses_stated_bound().
    std::vector<std::string> layers;
    std::uint32_t width = 0, height = 0;  ///< Size of the film.
    CropWindow window;
    Tone tone;
    TileGrid grid{};
    PartNumber part;

    /// Returns the empty film. Throws RunError if there is not enough memory.
    Film film(Planes planes = Planes::allocated) const;
};

/// The state of a tile file, from its first byte that is not part of a valid record.
enum class TileFileEnd {
    complete,    ///< The record `end` ends the file.
    incomplete,  ///< The file ends before or within a record.
    damaged      ///< The bytes are not those that were written.
};

/// Result of read_tiles.
struct TilesRead {
    TileFileEnd end;
    std::uint64_t valid_bytes;  ///< Size of the file up to the end of its last valid record.
};

/// Returns true if the file at `path` begins as a tile file does.
bool is_tile_file(const std::string& path);

/// Reads the header. Returns nullopt if the file ends before or within the header. Throws InputError, which names
/// `path`, if the file is not a tile file, or has another version of the format, or if its header is damaged.
std::optional<TileFileHeader> read_header(std::istream& in, const std::string& path);

/// Reads the tiles that follow the header. Adds them to `results`, and their pixels to the film if it has planes, up to
/// the first record that is not valid.
TilesRead read_tiles(std::istream& in, const TileFileHeader& header, Film& film, TileResults& results);

/// Returns the bytes up to the first tile.
std::string encode_header(const TileFileHeader& header);
/// Returns the record of a tile whose pixels are in the film. The film may be that of the tile alone. The bytes are
/// valid until the next call by the same thread.
std::string_view encode_tile(const TileFileHeader& header, std::uint64_t index, const TileReport& report,
                             const Film& film);

/// Adds the tile of a record that encode_tile returned, as read_tiles does. Returns false if the bytes are not
/// such a record of a new tile of the part; the pixels of the film are then not meaningful.
bool add_tile_record(const TileFileHeader& header, std::string_view record, Film& film, TileResults& results);

/// Writes a part with the tiles of `results`, which keeps their records, as write_file does. If some tiles of the part
/// are missing, the file has no record `end`.
void write_part(const std::string& path, const TileFileHeader& header, const TileResults& results);

}  // namespace kagero
