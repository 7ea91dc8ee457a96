#include "geometry/clearance/clear_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kagero {

namespace {

/// Indices of a cell along x, y and z.
using Cell = std::array<std::int32_t, 3>;

/// Range of cells; `lower` is inclusive and `upper` is exclusive.
struct CellBox {
    Cell lower, upper;
};

/// Summed-volume table of the cells that contain a surface: it gives the number of such cells in any range of cells.
class OccupiedCells {
public:
    OccupiedCells(const Cell& counts, const std::vector<CellClearance>& cells)
        : counts_(counts), sums_(std::size_t(counts[0] + 1) * std::size_t(counts[1] + 1) * std::size_t(counts[2] + 1)) {
        auto cell = cells.begin();
        for (std::int32_t z = 1; z <= counts_[2]; ++z)
            for (std::int32_t y = 1; y <= counts_[1]; ++y)
                for (std::int32_t x = 1, row_sum = 0; x <= counts_[0]; ++x) {
                    row_sum += !(cell++)->content.empty();
                    sums_[at(x, y, z)] =
                        row_sum + sums_[at(x, y - 1, z)] + sums_[at(x, y, z - 1)] - sums_[at(x, y - 1, z - 1)];
                }
    }
    /// Returns the numbers of cells along x, y and z.
    const Cell& cell_counts() const { return counts_; }
    /// Returns true if no cell of the range contains a surface.
    bool is_empty(const CellBox& box) const {
        const auto &a = box.lower, &b = box.upper;
        const auto sum_below = [&](std::int32_t z) {
            return sums_[at(b[0], b[1], z)] - sums_[at(a[0], b[1], z)] - sums_[at(b[0], a[1], z)] +
                   sums_[at(a[0], a[1], z)];
        };
        return sum_below(b[2]) == sum_below(a[2]);
    }

private:
    std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return (std::size_t(z) * std::size_t(counts_[1] + 1) + std::size_t(y)) * std::size_t(counts_[0] + 1) +
               std::size_t(x);
    }

    Cell counts_;  ///< Numbers of cells along x, y and z.
    /// For each corner of cells: number of cells with surfaces whose x, y and z are all less than those of the corner.
    std::vector<std::int32_t> sums_;
};

/// Grows a range of cells without surfaces from one such cell. In each round, every side advances by one layer of cells
/// if that layer is in the grid and contains no surface. A side that does not advance stops; the other sides continue.
CellBox grow_box(const OccupiedCells& occupied, const Cell& cell) {
    CellBox box{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
    bool grows[3][2] = {{true, true}, {true, true}, {true, true}};  // for each axis: lower side, upper side
    for (bool has_grown = true; has_grown;) {
        has_grown = false;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool upper : {false, true}) {
                if (!grows[k][upper]) continue;
                CellBox layer = box;
                if (upper) {
                    layer.lower[k] = box.upper[k];
                    layer.upper[k] = box.upper[k] + 1;
                } else {
                    layer.upper[k] = box.lower[k];
                    layer.lower[k] = box.lower[k] - 1;
                }
                grows[k][upper] =
                    layer.lower[k] >= 0 && layer.upper[k] <= occupied.cell_counts()[k] && occupied.is_empty(layer);
                if (!grows[k][upper]) continue;
                upper ? ++box.upper[k] : --box.lower[k];
                has_grown = true;
            }
        }
    }
    return box;
}

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Finds the clear boxes of all cells of a grid.
class ClearBoxBuilder {
public:
    ClearBoxBuilder(const std::array<std::uint32_t, 3>& counts, const std::vector<CellClearance>& cells)
        : counts_{std::int32_t(counts[0]), std::int32_t(counts[1]), std::int32_t(counts[2])},
          stride_{1, std::size_t{counts[0]}, std::size_t{counts[0]} * counts[1]}, cells_(cells),
          occupied_(counts_, cells) {
        // The boxes 0 to 5 are the half spaces beyond the faces of the grid; box 6 is empty.
        for (std::size_t k = 0; k < 3; ++k) {
            GridBox below{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}}, above = below;
            below.upper[k] = 0;
            above.lower[k] = float(counts[k]);
            add(below);
            add(above);
        }
        add({{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}});
        result_.box_index.assign(cells.size(), empty_box);
    }
    ClearBoxes operator()() {
        for (const std::uint32_t i : farthest_first()) {
            const Cell cell{std::int32_t(i % stride_[1]), std::int32_t(i % stride_[2] / stride_[1]),
                            std::int32_t(i / stride_[2])};
            // A neighbour's box is used if its faces are at least this far from the cell's centre, in cell edges: half
            // the edge of the largest cube in a sphere of radius `distance`, distance/√3, minus ½.
            const float min_distance = cells_[i].distance * 0.577f - 0.5f;
            if (!use_neighbour_box(i, cell, std::max(min_distance, 0.0f)) && cells_[i].content.empty()) {
                result_.box_index[i] = float(result_.boxes.size() / 6);
                add(bounds_of(grow_box(occupied_, cell)));
            }
        }
        return std::move(result_);
    }

private:
    static constexpr float empty_box = 6;  ///< Index of the empty box.

    /// Returns all cells in order of decreasing CellClearance::distance, so that a cell can use the box of a neighbour
    /// with a greater distance. This is a counting sort with buckets of half a cell edge.
    std::vector<std::uint32_t> farthest_first() const {
        const auto bucket = [](const CellClearance& cell) { return std::size_t(2 * std::min(cell.distance, 500.0f)); };
        // Number of cells per bucket; after the scan, position in `order` of the bucket's next cell.
        std::array<std::uint32_t, 1001> positions{};
        for (const CellClearance& cell : cells_) ++positions[bucket(cell)];
        std::exclusive_scan(positions.rbegin(), positions.rend(), positions.rbegin(), 0u);
        std::vector<std::uint32_t> order(cells_.size());
        for (std::uint32_t i = 0; i < cells_.size(); ++i) order[positions[bucket(cells_[i])]++] = i;
        return order;
    }
    void add(const GridBox& box) {
        for (const auto& corner : {box.lower, box.upper})
            result_.boxes.insert(result_.boxes.end(), corner.begin(), corner.end());
    }

    /// Assigns the box of one of its six neighbours to cell i. It chooses the box whose nearest face is farthest from
    /// the cell's centre. Returns false and assigns no box if this distance is less than `min_distance`, in cell edges.
    bool use_neighbour_box(std::uint32_t i, const Cell& cell, float min_distance) {
        bool found = false;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool upper : {false, true}) {
                if (cell[k] == (upper ? counts_[k] - 1 : 0)) continue;
                const float neighbour_box = result_.box_index[upper ? i + stride_[k] : i - stride_[k]],
                            distance = distance_to_faces(&result_.boxes[6 * std::size_t(neighbour_box)], cell);
                if (distance >= min_distance) {
                    min_distance = distance;
                    result_.box_index[i] = neighbour_box;
                    found = true;
                }
            }
        }
        return found;
    }
    /// Returns the distance from a cell's centre to the nearest face of a box, in cell edges; negative if the centre is
    /// outside the box.
    static float distance_to_faces(const float* bounds, const Cell& cell) {
        float least = infinity;
        for (std::size_t k = 0; k < 3; ++k) {
            const float middle = float(cell[k]) + 0.5f;
            least = std::min({least, middle - bounds[k], bounds[3 + k] - middle});
        }
        return least;
    }
    /// Returns the box of a range of cells. Every side is extended into the adjacent layer of cells, up to the surfaces
    /// in that layer. A side on the grid's boundary is extended to infinity.
    GridBox bounds_of(const CellBox& cells) const {
        GridBox box;
        for (std::size_t k = 0; k < 3; ++k) {
            box.lower[k] = float(cells.lower[k]);
            box.upper[k] = float(cells.upper[k]);
        }
        for (std::size_t k = 0; k < 3; ++k) {
            box.lower[k] = -(cells.lower[k] > 0 ? extension_bound(box, k, -1, cells.lower[k] - 1) : infinity);
            box.upper[k] = cells.upper[k] < counts_[k] ? extension_bound(box, k, 1, cells.upper[k]) : infinity;
        }
        return box;
    }
    /// Returns the coordinate along axis k up to which the box can be extended into a layer of cells, multiplied by
    /// `sign`. The sign is 1 for the upper side of the box and −1 for the lower side.
    float extension_bound(const GridBox& box, std::size_t k, int sign, std::int32_t layer) const {
        constexpr float margin = 0.01f;  // in cell edges; exceeds the rounding error of positions in the kernels
        float bound = sign > 0 ? float(layer + 1) : -float(layer);
        Cell begin, end;
        for (std::size_t j = 0; j < 3; ++j) {
            begin[j] = j == k ? layer : std::max(0, std::int32_t(std::floor(std::max(box.lower[j], 0.0f))));
            end[j] = j == k ? layer + 1 : std::int32_t(std::ceil(std::min(box.upper[j], float(counts_[j]))));
        }
        for (std::int32_t z = begin[2]; z < end[2]; ++z)
            for (std::int32_t y = begin[1]; y < end[1]; ++y)
                for (std::int32_t x = begin[0]; x < end[0]; ++x)
                    for (const GridBox& content :
                         cells_[std::size_t(z) * stride_[2] + std::size_t(y) * stride_[1] + std::size_t(x)].content)
                        if (overlap_except_along(box, content, k))
                            bound = std::min(bound, (sign > 0 ? content.lower[k] : -content.upper[k]) - margin);
        return bound;
    }
    /// Returns true if two boxes overlap along both axes other than k.
    static bool overlap_except_along(const GridBox& a, const GridBox& b, std::size_t k) {
        for (std::size_t j = 0; j < 3; ++j)
            if (j != k && !(a.lower[j] <= b.upper[j] && b.lower[j] <= a.upper[j])) return false;
        return true;
    }

    const Cell counts_;  ///< Numbers of cells along x, y and z.
    const std::array<std::size_t, 3> stride_;  ///< Differences of the indices of neighbours along x, y and z.
    const std::vector<CellClearance>& cells_;
    const OccupiedCells occupied_;
    ClearBoxes result_;
};

}  // namespace

ClearBoxes grow_clear_boxes(const std::array<std::uint32_t, 3>& counts, const std::vector<CellClearance>& cells) {
    return ClearBoxBuilder(counts, cells)();
}

}  // namespace kagero
