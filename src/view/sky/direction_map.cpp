#include "view/sky/direction_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr std::uint32_t least_cells = 4, most_cells = 128;
/// Number of corners beyond which the map is emptied: about 40 MB.
constexpr std::uint64_t most_corners = 2'000'000;

using Float3 = std::array<float, 3>;

float distance_of(const Float3& a, const Float3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

/// The corners of a block as a grid.
struct Corners {
    const MapBlock& block;

    const SkyEnd& at(std::uint32_t row, std::uint32_t column) const {
        return block.corners[row * (block.cells + 1) + column];
    }
    /// Returns the length of the second difference along a row or a column, next to corner (row, column). Returns
    /// infinity if the three rays do not all reach the same sky.
    float second_difference(std::uint32_t row, std::uint32_t column, bool along_row) const {
        const std::uint32_t last = block.cells - 1;
        std::uint32_t r = row, c = column;
        (along_row ? c : r) = std::clamp(along_row ? c : r, 1u, last);
        const SkyEnd &a = along_row ? at(r, c - 1) : at(r - 1, c), &b = at(r, c),
                     &d = along_row ? at(r, c + 1) : at(r + 1, c);
        if (a.kind != b.kind || d.kind != b.kind || !b.reaches_sky()) return infinite;
        Float3 difference;
        for (std::size_t k = 0; k < 3; ++k) difference[k] = a.direction[k] - 2 * b.direction[k] + d.direction[k];
        return distance_of(difference, {});
    }
    bool have_same_kind(std::uint32_t row, std::uint32_t column) const {
        const SkyEnd::Kind kind = at(row, column).kind;
        return at(row, column + 1).kind == kind && at(row + 1, column).kind == kind &&
               at(row + 1, column + 1).kind == kind;
    }
};

float error_of_cell(const Corners& corners, std::uint32_t row, std::uint32_t column) {
    if (!corners.have_same_kind(row, column)) return infinite;
    const SkyEnd::Kind kind = corners.at(row, column).kind;
    if (kind == SkyEnd::Kind::captured) return 0;
    float along_rows = 0, along_columns = 0;
    for (std::uint32_t i = 0; i < 4; ++i) {
        const std::uint32_t r = row + i / 2, c = column + i % 2;
        along_rows = std::max(along_rows, corners.second_difference(r, c, true));
        along_columns = std::max(along_columns, corners.second_difference(r, c, false));
    }
    return (along_rows + along_columns) / 8;
}

/// Returns the angle on the sky per length on the face. If it depends strongly on the axis, the sky is filtered with a
/// compromise. Returns a large number if the rays do not reach the same sky.
float magnification_of_cell(const Corners& corners, std::uint32_t row, std::uint32_t column) {
    constexpr float large = 100;
    const SkyEnd &a = corners.at(row, column), &b = corners.at(row, column + 1), &c = corners.at(row + 1, column);
    if (!corners.have_same_kind(row, column) || !a.reaches_sky()) return large;
    const float inverse = float(corners.block.cells / map_block_width);
    const float first = inverse * distance_of(a.direction, b.direction),
                second = inverse * distance_of(a.direction, c.direction);
    return mean_magnification(first, second);
}

void set_cells(MapBlock& block) {
    const Corners corners{block};
    block.error.clear();
    block.magnification.clear();
    for (std::uint32_t row = 0; row < block.cells; ++row)
        for (std::uint32_t column = 0; column < block.cells; ++column) {
            block.error.push_back(error_of_cell(corners, row, column));
            block.magnification.push_back(magnification_of_cell(corners, row, column));
        }
}

/// Returns the number of cells along an edge of a new block: a power of two with cells that are narrow enough.
std::uint32_t first_cells(double first_width) {
    std::uint32_t cells = least_cells;
    while (cells < most_cells && map_block_width / cells > first_width) cells *= 2;
    return cells;
}

/// Divides a block into more cells, or a new block into `first` cells along an edge. Corners that the block has already
/// keep their ends; the positions of the others, which must be traced, are added to `missing`.
void divide(MapBlock& block, std::uint32_t first, std::vector<std::uint32_t>& missing) {
    const std::uint32_t before = block.cells, cells = before == 0 ? first : 2 * before, stride = cells + 1;
    std::vector<SkyEnd> corners(stride * stride);
    for (std::uint32_t row = 0; row <= cells; ++row)
        for (std::uint32_t column = 0; column <= cells; ++column) {
            if (before != 0 && row % 2 == 0 && column % 2 == 0)
                corners[row * stride + column] = block.corners[row / 2 * (before + 1) + column / 2];
            else missing.push_back(row * stride + column);
        }
    block.corners = std::move(corners);
    block.cells = cells;
}

}  // namespace

void CubeRow::set(const Double3& first, const Double3& step, std::uint32_t count) {
    constexpr float half = 0.5f * map_blocks_per_edge, last = 2 * half * (1 - 0x1p-24f);
    face.resize(count);
    for (auto* numbers : {&s, &t, &inverse_depth}) numbers->resize(count);
    const float begin[3] = {float(first[0]), float(first[1]), float(first[2])},
                by[3] = {float(step[0]), float(step[1]), float(step[2])};
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto n = float(std::int32_t(i));
        const float x = begin[0] + n * by[0], y = begin[1] + n * by[1], z = begin[2] + n * by[2], ax = std::abs(x),
                    ay = std::abs(y), az = std::abs(z);
        const bool x_is_greatest = (ax >= ay) & (ax >= az), z_is_greatest = !x_is_greatest & (az > ay);
        const float normal = x_is_greatest   ? x
                             : z_is_greatest ? z
                                             : y,
                    across = x_is_greatest ? y : x, along = z_is_greatest ? y : z, inverse = 1 / std::abs(normal);
        const std::uint32_t axis = x_is_greatest ? 0 : z_is_greatest ? 4 : 2;
        s[i] = std::min(std::max((across * inverse + 1) * half, 0.0f), last);
        t[i] = std::min(std::max((along * inverse + 1) * half, 0.0f), last);
        inverse_depth[i] = inverse;
        face[i] = axis + (normal < 0 ? 1 : 0);
    }
}

Double3 direction_of(std::uint32_t block, double s, double t) {
    const std::uint32_t column = block % map_blocks_per_edge, rest = block / map_blocks_per_edge,
                        row = rest % map_blocks_per_edge, face = rest / map_blocks_per_edge, axis = face / 2;
    const double first = (column + s) * map_block_width - 1, second = (row + t) * map_block_width - 1;
    Double3 direction{};
    direction[axis] = face % 2 == 0 ? 1 : -1;
    direction[axis == 0 ? 1 : 0] = first;
    direction[axis == 2 ? 1 : 2] = second;
    return direction;
}

void DirectionMap::trace(const Plan& plan, const std::vector<std::uint32_t>& blocks, double first_width) {
    std::vector<std::vector<std::uint32_t>> missing(blocks.size());
    std::vector<Double3> directions;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        MapBlock& block = blocks_[blocks[i]];
        divide(block, first_cells(first_width), missing[i]);
        corner_count_ += missing[i].size();
        for (const std::uint32_t corner : missing[i])
            directions.push_back(direction_of(blocks[i], double(corner % (block.cells + 1)) / block.cells,
                                              double(corner / (block.cells + 1)) / block.cells));
    }
    const std::vector<SkyEnd> ends = trace_sky_ends(plan, directions, rays_, seconds_);
    auto next = ends.begin();
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        MapBlock& block = blocks_[blocks[i]];
        for (const std::uint32_t corner : missing[i]) block.corners[corner] = *next++;
        set_cells(block);
    }
}

void DirectionMap::refine(const Plan& plan, const std::vector<std::uint32_t>& blocks, double max_error,
                          double first_width, double least_width) {
    if (corner_count_ > most_corners) {
        blocks_.assign(map_block_count, {});
        corner_count_ = 0;
    }
    for (;;) {
        std::vector<std::uint32_t> coarse;
        for (const std::uint32_t index : blocks) {
            const MapBlock& block = blocks_[index];
            const bool can_refine = block.cells < most_cells && map_block_width / block.cells > least_width;
            const bool is_inexact =
                std::any_of(block.error.begin(), block.error.end(), [&](float error) { return error > max_error; });
            const bool is_coarse = block.cells == 0 || (can_refine && is_inexact);
            if (is_coarse) coarse.push_back(index);
        }
        if (coarse.empty()) return;
        trace(plan, coarse, first_width);
    }
}

}  // namespace kagero
