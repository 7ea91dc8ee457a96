#include "parts/record.h"

#include <istream>

namespace kagero {
namespace {

/// Size of the kind and the size in front of the content of a record, in bytes.
constexpr std::size_t record_head = sizeof(std::uint32_t) + sizeof(std::uint64_t);

}  // namespace

ByteWriter begin_record(RecordKind kind, std::size_t size) {
    ByteWriter record;
    record.bytes.reserve(record_head + size + sizeof(std::uint64_t));
    record.put(static_cast<std::uint32_t>(kind));
    record.put(std::uint64_t{0});
    return record;
}

std::string finish_record(ByteWriter record) {
    const std::uint64_t size = record.bytes.size() - record_head;
    std::memcpy(record.bytes.data() + sizeof(std::uint32_t), &size, sizeof size);
    record.put(checksum(record.bytes));
    return std::move(record.bytes);
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
    if (left < record_head) return {RecordState::incomplete};
    std::string bytes(record_head, '\0');
    in.read(bytes.data(), record_head);
    ByteReader reader(bytes);
    Record record{RecordState::valid, static_cast<RecordKind>(reader.get<std::uint32_t>())};
    const auto size = reader.get<std::uint64_t>();
    std::uint64_t hash = 0;
    if (left - record_head < sizeof hash || size > left - record_head - sizeof hash) return {RecordState::incomplete};
    bytes.resize(record_head + size);
    in.read(bytes.data() + record_head, static_cast<std::streamsize>(size));
    in.read(reinterpret_cast<char*>(&hash), sizeof hash);
    if (!in) return {RecordState::incomplete};
    if (hash != checksum(bytes)) return {RecordState::damaged};
    bytes.append(reinterpret_cast<const char*>(&hash), sizeof hash);
    record.bytes = std::move(bytes);
    return record;
}

std::string_view record_content(std::string_view bytes) {
    return bytes.substr(record_head, bytes.size() - record_head - sizeof(std::uint64_t));
}

}  // namespace kagero
