#include "parts/record.h"

#include <istream>

namespace kagero {
namespace {

/// Size of the kind and the size in front of the content of a record, in bytes.
constexpr std::size_t record_head = sizeof(std::uint32_t) + sizeof(std::uint64_t);

/// Size of the checksum behind the content, in bytes.
constexpr std::size_t record_end = sizeof(std::uint64_t);

struct RecordHead {
    RecordKind kind;
    std::uint64_t size;  ///< The size of the content, in bytes.
};

/// Returns the head of bytes, which are not fewer than record_head.
RecordHead head_of(std::string_view bytes) {
    ByteReader reader(bytes);
    const auto kind = static_cast<RecordKind>(reader.get<std::uint32_t>());
    return {kind, reader.get<std::uint64_t>()};
}

/// Returns true if the last bytes are the checksum of the others. There are not fewer than record_end.
bool has_own_checksum(std::string_view bytes) {
    const std::size_t covered = bytes.size() - record_end;
    return ByteReader(bytes.substr(covered)).get<std::uint64_t>() == checksum(bytes.substr(0, covered));
}

}  // namespace

void begin_record(ByteWriter& record, RecordKind kind) {
    record.bytes.clear();
    record.put(static_cast<std::uint32_t>(kind));
    record.put(std::uint64_t{0});
}

void finish_record(ByteWriter& record) {
    const std::uint64_t size = record.bytes.size() - record_head;
    std::memcpy(record.bytes.data() + sizeof(std::uint32_t), &size, sizeof size);
    record.put(checksum(record.bytes));
}

bool is_record(std::string_view bytes, RecordKind kind) {
    if (bytes.size() < record_head + record_end) return false;
    const RecordHead head = head_of(bytes);
    return head.kind == kind && head.size == bytes.size() - record_head - record_end && has_own_checksum(bytes);
}

std::uint64_t bytes_left(std::istream& in) {
    const auto position = in.tellg();
    in.seekg(0, std::ios::end);
    const auto end = in.tellg();
    in.seekg(position);
    return static_cast<std::uint64_t>(end - position);
}

Record read_record(std::istream& in) {
    const std::uint64_t left = bytes_left(in);
    std::string bytes(record_head, '\0');
    if (left < record_head + record_end || !in.read(bytes.data(), record_head)) return {RecordState::incomplete};
    const RecordHead head = head_of(bytes);
    if (head.size > left - record_head - record_end) return {RecordState::incomplete};
    bytes.resize(record_head + head.size + record_end);
    in.read(bytes.data() + record_head, static_cast<std::streamsize>(bytes.size() - record_head));
    if (!in) return {RecordState::incomplete};
    if (!has_own_checksum(bytes)) return {RecordState::damaged};
    return {RecordState::valid, head.kind, std::move(bytes)};
}

std::string_view record_content(std::string_view bytes) {
    return bytes.substr(record_head, bytes.size() - record_head - record_end);
}

}  // namespace kagero
