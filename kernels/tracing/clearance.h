/// How far surfaces are at least.
#pragma once

#include "kernels/abi.h"
#include "kernels/stepping/curve.h"

namespace kagero {

/// Lower bounds of the distances from q to the nearest surface; all in the grid's stretched space. From a cell's centre to q the distance
/// changes by the way between them at most; and all surfaces lie within the grid.
template <class V>
V clearance_at(const ClearanceGrid& grid, const Vec3<V>& q) {
    using S = ScalarOf<V>;
    const V per_cell(S(1 / grid.cell)), size(S(grid.cell)), zero(S(0)), half(S(0.5));
    const V at[3] = {q.x, q.y, q.z};
    V cell[3], aside2 = zero, beyond2 = zero;  // in cells
    for (int k = 0; k < 3; ++k) {
        const V into = mul_sub(at[k] - V(S(grid.origin[k])), per_cell, half), inside = pick(into > zero, into, zero);  // 0 where it is not a number
        cell[k] = nearest_whole(min(inside, V(S(grid.cells[k] - 1))));
        const V aside = into - cell[k], beyond = max(abs(aside) - half, zero);
        aside2 = mul_add(aside, aside, aside2), beyond2 = mul_add(beyond, beyond, beyond2);
    }
    const V at_center = look_up(grid.distance, cell[0], cell[1], cell[2], int(grid.cells[0]), int(grid.cells[1]));
    const V near_center = neg_mul_add(size, root(aside2), at_center);
    return any(beyond2 > zero) ? max(near_center, size * root(beyond2)) : near_center;
}

}  // namespace kagero
