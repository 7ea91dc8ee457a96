/// Iteration over the set bits of a lane mask.
#pragma once

#include <cstdint>

namespace kagero {

/// A range: the indices of the set bits in ascending order, for loops `for (const int i : lanes_in(bits))`.
class lanes_in {
public:
    explicit constexpr lanes_in(std::uint64_t bits) : remaining_(bits) {}
    constexpr lanes_in begin() const { return *this; }
    constexpr lanes_in end() const { return lanes_in(0); }
    constexpr int operator*() const { return __builtin_ctzll(remaining_); }
    constexpr lanes_in& operator++() { return remaining_ &= remaining_ - 1, *this; }
    constexpr bool operator!=(const lanes_in& other) const { return remaining_ != other.remaining_; }

private:
    std::uint64_t remaining_;
};

}  // namespace kagero
