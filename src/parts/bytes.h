/// Numbers and texts as bytes, little-endian.
#pragma once

#include "error.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace kagero {

static_assert(std::endian::native == std::endian::little, "tile files contain numbers as they are in memory");

/// Returns a 64-bit checksum of bytes. `seed` is the checksum of preceding bytes. A change of one byte always changes
/// the checksum: every step can be inverted, so that different states stay different. Four independent lanes of 64-bit
/// words make the checksum about as fast as memory.
inline std::uint64_t checksum(std::string_view bytes, std::uint64_t seed = 0) {
    constexpr std::uint64_t multiplier = 0x9e3779b97f4a7c15u;  // an odd number, from the golden ratio
    constexpr std::size_t word = sizeof(std::uint64_t), block = 4 * word;
    const auto mix = [](std::uint64_t state, std::uint64_t with) { return std::rotl((state ^ with) * multiplier, 29); };
    const auto mix_word_at = [&](std::uint64_t& state, std::size_t begin) {
        std::uint64_t read;
        std::memcpy(&read, bytes.data() + begin, word);
        state = mix(state, read);
    };
    std::uint64_t a = seed, b = ~seed, c = seed + 1, d = ~seed - 1;  // an array would not be kept in registers
    std::size_t i = 0;
    for (; i + block <= bytes.size(); i += block) {
        mix_word_at(a, i);
        mix_word_at(b, i + word);
        mix_word_at(c, i + 2 * word);
        mix_word_at(d, i + 3 * word);
    }
    std::uint64_t hash = mix(mix(mix(mix(bytes.size(), a), b), c), d);
    for (; i < bytes.size(); ++i) hash = mix(hash, static_cast<unsigned char>(bytes[i]));
    return hash ^ hash >> 32;
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
    template <class Number>
    void put_list(const std::vector<Number>& numbers) {
        static_assert(std::is_trivially_copyable_v<Number>);
        put(std::uint64_t{numbers.size()});
        put_raw(numbers.data(), numbers.size() * sizeof(Number));
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
    std::string get_text() { return std::string(get_view()); }
    /// Reads a text without a copy.
    std::string_view get_view() {
        const auto size = get<std::uint64_t>();
        require(size);
        const std::string_view text = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return text;
    }
    /// Reads numbers that put_list has written.
    template <class Number>
    std::vector<Number> get_list() {
        const auto size = get<std::uint64_t>();
        if (size > rest_.size() / sizeof(Number)) refuse_short();
        std::vector<Number> numbers(size);
        get_raw(numbers.data(), size * sizeof(Number));
        return numbers;
    }
    void get_raw(void* data, std::size_t size) {
        require(size);
        if (size > 0) std::memcpy(data, rest_.data(), size);
        rest_.remove_prefix(size);
    }
    bool empty() const { return rest_.empty(); }

private:
    [[noreturn]] static void refuse_short() { throw InputError("a record is shorter than its content"); }
    void require(std::uint64_t size) const {
        if (size > rest_.size()) refuse_short();
    }
    std::string_view rest_;
};

}  // namespace kagero
