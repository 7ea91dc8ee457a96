#include "adaptive/write_ends.h"

#include "adaptive/end_interpolant.h"

#include <algorithm>

namespace kagero {

namespace {

EndInterpolant interpolant_of(const RayCell& cell) {
    EndLattice lattice;
    for (std::size_t i = 0; i < 9; ++i) lattice[i] = &cell.nodes[i];
    return EndInterpolant(lattice);
}

}  // namespace

void write_ends(const RayCell& cell, const Tile& tile, TracedRays& rays) {
    EndInterpolant interpolant = interpolant_of(cell);
    const double scale = 2.0 / cell.edge;
    const std::uint32_t x0 = std::max(cell.x, tile.x0), x1 = std::min(cell.x + cell.edge, tile.x1),
                        y0 = std::max(cell.y, tile.y0), y1 = std::min(cell.y + cell.edge, tile.y1);
    const auto index = [&](std::uint32_t x, std::uint32_t y) {
        return std::size_t{y - tile.y0} * (tile.x1 - tile.x0) + (x - tile.x0);
    };
    for (std::uint32_t y = y0; y < y1; ++y) {
        interpolant.set_row(scale * (y - cell.y));
        for (std::uint32_t x = x0; x < x1; ++x) interpolant.write(scale * (x - cell.x), rays.ends[index(x, y)]);
    }
    const auto set_traced = [&](const std::array<std::uint32_t, 2>& at, const RayEnd& end) {
        const std::uint32_t x = cell.x + at[0], y = cell.y + at[1];
        if (x < x0 || x >= x1 || y < y0 || y >= y1 || at[0] == cell.edge || at[1] == cell.edge) return;
        rays.ends[index(x, y)] = end;
        rays.traced[index(x, y)] = true;
    };
    for (std::uint32_t i = 0; i < 9; ++i) set_traced(cell.node_position(i), cell.nodes[i]);
    for (std::uint32_t i = 0; i < 4; ++i) set_traced(cell.test_position(i), cell.tests[i]);
}

void write_ends(const Tile& tile, TracedRays& rays) {
    for (const RayCell& cell : rays.cells) write_ends(cell, tile, rays);
}

std::array<RayCell, 4> quarters_of(const RayCell& cell) {
    std::array<RayCell, 4> quarters;
    EndInterpolant interpolant = interpolant_of(cell);
    const double scale = 2.0 / cell.edge;
    for (std::uint32_t i = 0; i < 4; ++i) {
        RayCell& quarter = quarters[i];
        quarter.edge = cell.edge / 2;
        quarter.x = cell.x + i % 2 * quarter.edge;
        quarter.y = cell.y + i / 2 * quarter.edge;
        quarter.error = cell.error;
        const auto set = [&](const std::array<std::uint32_t, 2>& at, RayEnd& end) {
            interpolant.set_row(scale * (quarter.y - cell.y + at[1]));
            interpolant.write(scale * (quarter.x - cell.x + at[0]), end);
        };
        for (std::uint32_t k = 0; k < 9; ++k) set(quarter.node_position(k), quarter.nodes[k]);
        for (std::uint32_t k = 0; k < 4; ++k) set(quarter.test_position(k), quarter.tests[k]);
    }
    return quarters;
}

}  // namespace kagero
