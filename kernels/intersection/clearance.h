/// Boxes that contain no surface, taken from the clearance grid.
#pragma once

#include "kernels/abi.h"
#include "kernels/integrators/curve.h"
#include "kernels/simd/lane_memory.h"

namespace kagero {

/// One axis-aligned box without a surface for each lane. Initially the boxes are empty.
template <class V>
struct ClearBox {
    V box_index = V(ScalarOf<V>(-1));  ///< Index of the box in ClearanceGrid::boxes; −1 before the first `update`.
    Vec3<V> lower = largest(), upper = V(ScalarOf<V>(-1)) * largest();

    /// Returns the lanes whose clear box contains the box `extent`.
    KAGERO_INLINE MaskOf<V> contains(const Extent<V>& extent) const {
        return (extent.lower.x >= lower.x) & (extent.lower.y >= lower.y) & (extent.lower.z >= lower.z) &
               (extent.upper.x <= upper.x) & (extent.upper.y <= upper.y) & (extent.upper.z <= upper.z);
    }
    /// Returns a lower bound on the time that a curve needs from q to the boundary of the box; negative if q is outside
    /// the box. Time is the parameter of the curve. `min_times` is the result of `min_times_per_length`.
    KAGERO_INLINE V min_exit_time(const Vec3<V>& q, const Extent<V>& min_times) const {
        const Vec3<V> down = q - lower, up = upper - q;
        return min(min(min(down.x * min_times.lower.x, up.x * min_times.upper.x),
                       min(down.y * min_times.lower.y, up.y * min_times.upper.y)),
                   min(down.z * min_times.lower.z, up.z * min_times.upper.z));
    }
    /// Replaces the boxes of `lanes` by the clear boxes of the grid around q. Returns the lanes whose box has changed.
    std::uint64_t update(const ClearanceGrid& grid, const Vec3<V>& q, std::uint64_t lanes);

private:
    /// Returns the vector whose components are the greatest finite number.
    static Vec3<V> largest() {
        const V most(std::numeric_limits<ScalarOf<V>>::max());
        return {most, most, most};
    }
};

/// Returns lower bounds on the time that a curve needs to move by one unit of length along each axis: in the negative
/// direction (`lower`) and in the positive direction (`upper`). Time is the parameter of the curve. `speeds` contains
/// bounds on the derivative of the curve.
template <class V>
Extent<V> min_times_per_length(const Extent<V>& speeds) {
    const V min_speed(std::numeric_limits<ScalarOf<V>>::min() * 4);  // its reciprocal does not overflow
    const auto time = [&min_speed](const V& speed) { return V(ScalarOf<V>(1)) / max(speed, min_speed); };
    const Vec3<V>&down = speeds.lower, &up = speeds.upper;
    return {{time(-down.x), time(-down.y), time(-down.z)}, {time(up.x), time(up.y), time(up.z)}};
}

/// Returns the index of the grid's clear box around q. Outside the grid, the box is one of the six half spaces beyond
/// the faces of the grid: the one in which q is farthest from its face.
template <class V>
V clear_box_at(const ClearanceGrid& grid, const Vec3<V>& q) {
    using S = ScalarOf<V>;
    const V zero(S(0)), half(S(0.5));
    const V at[3] = {q.x, q.y, q.z};
    V cell[3], max_excess = zero, side_index = zero;
    for (int k = 0; k < 3; ++k) {
        const V last(S(grid.cells[k] - 1));
        // Coordinate in cells: an integer at cell centres.
        const V coordinate = fms(at[k] - V(S(grid.origin[k])), V(S(1 / grid.cell[k])), half);
        cell[k] = nearest_integer(min(select(coordinate > zero, coordinate, zero), last));  // 0 for NaN
        const V below = -half - coordinate, above = coordinate - last - half;
        side_index = select(below > max_excess, V(S(2 * k)), side_index);
        max_excess = max(max_excess, below);
        side_index = select(above > max_excess, V(S(2 * k + 1)), side_index);
        max_excess = max(max_excess, above);
    }
    const V inside = look_up(grid.box_index, cell[0], cell[1], cell[2], int(grid.cells[0]), int(grid.cells[1]));
    return select(max_excess > zero, side_index, inside);
}

template <class V>
std::uint64_t ClearBox<V>::update(const ClearanceGrid& grid, const Vec3<V>& q, std::uint64_t lanes) {
    using S = ScalarOf<V>;
    const V box_here = clear_box_at(grid, q);
    const std::uint64_t changing = lanes & to_bits(abs(box_here - box_index) > V(S(0.5)));
    if (!changing) return 0;
    const MaskOf<V> changes = from_bits<V>(changing);
    // Returns the lower (bound_index 0) or upper (1) bounds of the new boxes along axis k, and `old_bound` in the lanes
    // whose box does not change.
    const auto bound = [&](int bound_index, int k, const V& old_bound) {
        const V cells = look_up(grid.boxes, V(S(3 * bound_index + k)), box_here, V(S(0)), 6, 1);
        return select(changes, fma(V(S(grid.cell[k])), cells, V(S(grid.origin[k]))), old_bound);
    };
    box_index = select(changes, box_here, box_index);
    lower = {bound(0, 0, lower.x), bound(0, 1, lower.y), bound(0, 2, lower.z)};
    upper = {bound(1, 0, upper.x), bound(1, 1, upper.y), bound(1, 2, upper.z)};
    return changing;
}

}  // namespace kagero
