/// Collects the ends of a packet's rays as columns and writes them to memory as rows. Twenty scalar stores for each ray
/// would be a considerable part of the cost of a straight ray.
#pragma once

#include "kernels/abi.h"
#include "kernels/numeric/vec.h"
#include "kernels/simd/bits.h"
#include "kernels/simd/lane_memory.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace kagero {

/// One column for each number of RayEnd. A column is selected by the offset of its member in RayEnd.
template <class V>
class EndColumns {
    static constexpr int W = lane_count<V>;

public:
    /// Initializes the 32-bit words with those of `common`. All columns of doubles must be set before `write`.
    KAGERO_INLINE explicit EndColumns(const RayEnd& common) {
        Row row;
        std::memcpy(&row, &common, sizeof row);
        for (int k = 0; k < word_count; ++k) std::fill_n(words_[k], W, row.words[k]);
    }
    /// Sets one column of doubles, or three consecutive columns.
    KAGERO_INLINE void set(std::size_t offset, const V& numbers) {
        to_doubles(numbers, numbers_[offset / sizeof(double)]);
    }
    KAGERO_INLINE void set(std::size_t offset, const Vec3<V>& a) {
        set(offset, a.x);
        set(offset + sizeof(double), a.y);
        set(offset + 2 * sizeof(double), a.z);
    }
    /// Sets a column of counts, which are whole numbers, and returns the sum over `lanes`. The loops are simple so that
    /// the compiler vectorizes them.
    KAGERO_INLINE std::uint64_t set_counts(std::size_t offset, const V& counts, std::uint64_t lanes) {
        alignas(64) double numbers[W];
        to_doubles(select(from_bits<V>(lanes), counts, V(ScalarOf<V>(0))), numbers);
        std::uint32_t* const words = words_[word_index(offset)];
        for (int i = 0; i < W; ++i) words[i] = static_cast<std::uint32_t>(numbers[i]);
        std::uint64_t sum = 0;
        for (int i = 0; i < W; ++i) sum += words[i];
        return sum;
    }
    /// Sets a column of 32-bit words.
    KAGERO_INLINE void set_words(std::size_t offset, const std::uint32_t (&words)[W]) {
        std::copy_n(words, W, words_[word_index(offset)]);
    }

    /// Writes the rows of `lanes`, each to its element of `ends`.
    KAGERO_INLINE void write(std::uint64_t lanes, RayEnd* const (&ends)[W]) const {
        if constexpr (W % 4 == 0) {
            RayEnd unused;
            const auto end = [&](int lane) {
                return reinterpret_cast<char*>((lanes >> lane) & 1 ? ends[lane] : &unused);
            };
            for (int i = 0; i < W; i += 4) {
                if (!((lanes >> i) & 15)) continue;
                char* const to[4] = {end(i), end(i + 1), end(i + 2), end(i + 3)};
                for (std::size_t k = 0; k < number_count; k += 4)
                    write_four(&numbers_[k], i, to, offsetof(Row, numbers) + k * sizeof(double));
                for (std::size_t k = 0; k < word_count; k += 4)
                    write_four(&words_[k], i, to, offsetof(Row, words) + k * sizeof(std::uint32_t));
            }
        } else {
            for (const int i : lanes_in(lanes)) {
                Row row;
                for (int k = 0; k < number_count; ++k) row.numbers[k] = numbers_[k][i];
                for (int k = 0; k < word_count; ++k) row.words[k] = words_[k][i];
                std::memcpy(static_cast<void*>(ends[i]), &row, sizeof row);
            }
        }
    }

private:
    static constexpr int number_count = 12, word_count = 8;
    /// The first part of RayEnd as arrays: its doubles, followed by its 32-bit words. The integrals follow; they are
    /// written only where they are requested (RayEndWriter).
    struct Row {
        double numbers[number_count];
        std::uint32_t words[word_count];
    };
    static_assert(sizeof(Row) == offsetof(RayEnd, action) && offsetof(RayEnd, q) == 0 &&
                  offsetof(RayEnd, steps) == offsetof(Row, words));
    /// Returns the index of the word at this offset of RayEnd.
    static constexpr std::size_t word_index(std::size_t offset) {
        return (offset - offsetof(Row, words)) / sizeof(std::uint32_t);
    }

    /// Transposes four columns of four lanes and writes them as parts of four rows.
    template <class T>
    KAGERO_INLINE static void write_four(const T (*columns)[W], int lane, char* const (&to)[4], std::size_t offset) {
        const auto row = [&](int i) { return reinterpret_cast<T*>(to[i] + offset); };
        registers::transpose(&columns[0][lane], &columns[1][lane], &columns[2][lane], &columns[3][lane],
                             {row(0), row(1), row(2), row(3)});
    }

    alignas(64) double numbers_[number_count][W];
    alignas(64) std::uint32_t words_[word_count][W];
};

}  // namespace kagero
