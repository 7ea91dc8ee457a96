/// Iteration over the set bits of a lane mask.
#pragma once

#include <cstdint>

namespace kagero {

/// The range of the indices of lanes whose bit is set, in ascending order: `for (const int i : lanes_in(bits))`.
class lanes_in {
public:
    explicit constexpr lanes_in(std::uint64_t bits) : rest_(bits) {}
    constexpr lanes_in begin() const { return *this; }
    constexpr lanes_in end() const { return lanes_in(0); }
    constexpr int operator*() const { return __builtin_ctzll(rest_); }
    constexpr lanes_in& operator++() { return rest_ &= rest_ - 1, *this; }
    constexpr bool operator!=(const lanes_in& other) const { return rest_ != other.rest_; }

private:
    std::uint64_t rest_;
};

}  // namespace kagero
