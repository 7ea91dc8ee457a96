/// Records of tile files: kind, size, content and checksum (tile_file.h describes the format).
#pragma once

#include "parts/bytes.h"

#include <iosfwd>

namespace kagero {

enum class RecordKind : std::uint32_t { header = 1, tile = 2, end = 3 };

/// Begins a record in place of the writer's bytes. The content is then written behind them.
void begin_record(ByteWriter& record, RecordKind kind);
/// Completes a record that begin_record began.
void finish_record(ByteWriter& record);

enum class RecordState {
    valid,
    incomplete,  ///< The file ends before or within the record.
    damaged      ///< The bytes are not those that were written.
};

/// The result of read_record. Kind and bytes are set only if the record is valid.
struct Record {
    RecordState state;
    RecordKind kind{};
    std::string bytes{};  ///< All bytes of the record.
};
Record read_record(std::istream& in);
/// Returns true if bytes are one valid record of this kind, and nothing else.
bool is_record(std::string_view bytes, RecordKind kind);
/// Returns the content of a valid record.
std::string_view record_content(std::string_view bytes);

/// Returns the number of bytes from the current position to the end of a file.
std::uint64_t bytes_left(std::istream& in);

}  // namespace kagero
