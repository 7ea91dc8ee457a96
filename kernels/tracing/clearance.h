/// How far surfaces are at least.
#pragma once

#include "kernels/abi.h"
#include "kernels/stepping/curve.h"

namespace kagero {

/// Lower bounds of the distances from q to the nearest surface; all in the grid's stretched space. From a cell's centre to q the distance
/// changes by the way between them at most.
template <class V>
V clearance_at(const ClearanceGrid& grid, const Vec3<V>& q) {
    using S = ScalarOf<V>;
    const V per_cell(S(1 / grid.cell)), zero(S(0)), half(S(0.5));
    const V at[3] = {q.x, q.y, q.z};
    V cell[3], beyond2 = zero, aside2 = zero;
    for (int k = 0; k < 3; ++k) {
        const V u = at[k] - V(S(grid.origin[k])), beyond = max(max(-u, u - V(S(grid.cells[k] * grid.cell))), zero);
        beyond2 = mul_add(beyond, beyond, beyond2);
        const V into = mul_sub(u, per_cell, half), inside = pick(into > zero, into, zero);  // 0 where it is not a number
        cell[k] = nearest_whole(min(inside, V(S(grid.cells[k] - 1))));
        const V aside = into - cell[k];
        aside2 = mul_add(aside, aside, aside2);
    }
    const V at_center = look_up(grid.distance, cell[0], cell[1], cell[2], int(grid.cells[0]), int(grid.cells[1]));
    const V inside = neg_mul_add(V(S(grid.cell)), root(aside2), at_center);
    const MaskOf<V> outside = beyond2 > zero;
    return any(outside) ? pick(outside, root(beyond2), inside) : inside;
}

}  // namespace kagero
