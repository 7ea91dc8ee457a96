/// Parts of space without a surface.
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/curve.h"
#include "kernels/simd/lane_memory.h"

namespace kagero {

/// A box without a surface, its axes those of space; at first one that holds nothing.
template <class V>
struct ClearBox {
    V number = V(ScalarOf<V>(-1));  ///< of the grid's
    Vec3<V> lower = far(), upper = V(ScalarOf<V>(-1)) * far();

    KAGERO_INLINE MaskOf<V> holds(const Extent<V>& curve) const {
        return (curve.lower.x >= lower.x) & (curve.lower.y >= lower.y) & (curve.lower.z >= lower.z) &
               (curve.upper.x <= upper.x) & (curve.upper.y <= upper.y) & (curve.upper.z <= upper.z);
    }
    /// How far at least a curve goes on from q, in its parameter, before it leaves the box; below 0 where q is outside.
    KAGERO_INLINE V way_out(const Vec3<V>& q, const Extent<V>& times) const {
        const Vec3<V> down = q - lower, up = upper - q;
        return min(min(min(down.x * times.lower.x, up.x * times.upper.x),
                       min(down.y * times.lower.y, up.y * times.upper.y)),
                   min(down.z * times.lower.z, up.z * times.upper.z));
    }
    /// The grid's boxes around q become those of `lanes`; returns the lanes where they are others than before.
    std::uint64_t move(const ClearanceGrid& grid, const Vec3<V>& q, std::uint64_t lanes);

private:
    static Vec3<V> far() {
        const V most(std::numeric_limits<ScalarOf<V>>::max());
        return {most, most, most};
    }
};

/// How long at least a curve takes for a unit of length down and up each axis, where d/ds is within `speeds`.
template <class V>
Extent<V> least_times(const Extent<V>& speeds) {
    const V least(std::numeric_limits<ScalarOf<V>>::min() * 4);
    const auto time = [&least](const V& speed) { return V(ScalarOf<V>(1)) / max(speed, least); };
    const Vec3<V>&down = speeds.lower, &up = speeds.upper;
    return {{time(-down.x), time(-down.y), time(-down.z)}, {time(up.x), time(up.y), time(up.z)}};
}

/// Which of the grid's boxes is around q; outside of the grid it is the half of space that q is farthest in.
template <class V>
V clear_box_at(const ClearanceGrid& grid, const Vec3<V>& q) {
    using S = ScalarOf<V>;
    const V zero(S(0)), half(S(0.5));
    const V at[3] = {q.x, q.y, q.z};
    V cell[3], farthest = zero, beyond = zero;
    for (int k = 0; k < 3; ++k) {
        const V last(S(grid.cells[k] - 1)), into = fms(at[k] - V(S(grid.origin[k])), V(S(1 / grid.cell[k])), half);
        cell[k] = nearest_whole(min(select(into > zero, into, zero), last));  // 0 where it is not a number
        const V below = -half - into, above = into - last - half;
        beyond = select(below > farthest, V(S(2 * k)), beyond), farthest = max(farthest, below);
        beyond = select(above > farthest, V(S(2 * k + 1)), beyond), farthest = max(farthest, above);
    }
    const V inside = look_up(grid.box, cell[0], cell[1], cell[2], int(grid.cells[0]), int(grid.cells[1]));
    return select(farthest > zero, beyond, inside);
}

template <class V>
std::uint64_t ClearBox<V>::move(const ClearanceGrid& grid, const Vec3<V>& q, std::uint64_t lanes) {
    using S = ScalarOf<V>;
    const V there = clear_box_at(grid, q);
    const std::uint64_t moving = lanes & to_bits(abs(there - number) > V(S(0.5)));
    if (!moving) return 0;
    const MaskOf<V> moves = from_bits<V>(moving);
    const auto bound = [&](int side, int k, const V& before) {
        const V cells = look_up(grid.boxes, V(S(3 * side + k)), there, V(S(0)), 6, 1);
        return select(moves, fma(V(S(grid.cell[k])), cells, V(S(grid.origin[k]))), before);
    };
    number = select(moves, there, number);
    lower = {bound(0, 0, lower.x), bound(0, 1, lower.y), bound(0, 2, lower.z)};
    upper = {bound(1, 0, upper.x), bound(1, 1, upper.y), bound(1, 2, upper.z)};
    return moving;
}

}  // namespace kagero
