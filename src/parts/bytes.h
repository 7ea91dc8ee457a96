/// Numbers and texts as bytes, little-endian.
#pragma once

#include "error.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace kagero {

static_assert(std::endian::native == std::endian::little, "tile files contain numbers as they are in memory");

/// Returns the 64-bit FNV-1a hash of bytes (Fowler, Noll and Vo). A change of one byte always changes the hash, because
/// every step of the loop is invertible. `hash` is that of preceding bytes.
inline std::uint64_t fnv1a(std::string_view bytes, std::uint64_t hash = 0xcbf29ce484222325u) {
    for (const char byte : bytes) hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
    return hash;
}

/// Appends numbers and texts to bytes.
class ByteWriter {
public:
    template <class Number>
    void put(const Number& number) {
        static_assert(std::is_trivially_copyable_v<Number>);
        put_raw(&number, sizeof number);
    }
    void put_text(std::string_view text) {
        put(std::uint64_t{text.size()});
        bytes.append(text);
    }
    void put_raw(const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); }

    std::string bytes;
};

/// Reads numbers and texts from bytes. Throws InputError if too few bytes remain.
class ByteReader {
public:
    explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
    template <class Number>
    Number get() {
        static_assert(std::is_trivially_copyable_v<Number>);
        Number number;
        get_raw(&number, sizeof number);
        return number;
    }
    std::string get_text() {
        const auto size = get<std::uint64_t>();
        require(size);
        std::string text(rest_.substr(0, size));
        rest_.remove_prefix(size);
        return text;
    }
    void get_raw(void* data, std::size_t size) {
        require(size);
        if (size > 0) std::memcpy(data, rest_.data(), size);
        rest_.remove_prefix(size);
    }
    bool empty() const { return rest_.empty(); }

private:
    void require(std::uint64_t size) const {
        if (size > rest_.size()) throw InputError("a record is shorter than its content");
    }
    std::string_view rest_;
};

}  // namespace kagero
