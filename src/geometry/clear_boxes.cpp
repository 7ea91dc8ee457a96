#include "geometry/clear_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kagero {

namespace {

using Cell = std::array<std::int32_t, 3>;

/// The cells from `lower` to before `upper`.
struct CellBox {
    Cell lower, upper;
};

/// Which cells of a grid have a surface.
class Occupancy {
public:
    Occupancy(const Cell& counts, const std::vector<SurveyedCell>& cells)
        : cells_(counts), sums_(std::size_t(counts[0] + 1) * std::size_t(counts[1] + 1) * std::size_t(counts[2] + 1)) {
        auto cell = cells.begin();
        for (std::int32_t z = 1; z <= cells_[2]; ++z)
            for (std::int32_t y = 1; y <= cells_[1]; ++y)
                for (std::int32_t x = 1, in_row = 0; x <= cells_[0]; ++x) {
                    in_row += !(cell++)->content.empty();
                    sums_[at(x, y, z)] =
                        in_row + sums_[at(x, y - 1, z)] + sums_[at(x, y, z - 1)] - sums_[at(x, y - 1, z - 1)];
                }
    }
    const Cell& cells() const { return cells_; }
    bool is_empty(const CellBox& box) const {
        const auto &a = box.lower, &b = box.upper;
        const auto face = [&](std::int32_t z) {
            return sums_[at(b[0], b[1], z)] - sums_[at(a[0], b[1], z)] - sums_[at(b[0], a[1], z)] +
                   sums_[at(a[0], a[1], z)];
        };
        return face(b[2]) == face(a[2]);
    }

private:
    std::size_t at(std::int32_t x, std::int32_t y, std::int32_t z) const {
        return (std::size_t(z) * std::size_t(cells_[1] + 1) + std::size_t(y)) * std::size_t(cells_[0] + 1) +
               std::size_t(x);
    }

    Cell cells_;
    std::vector<std::int32_t> sums_;  ///< occupied cells of all boxes that begin at the grid's first corner
};

/// The empty cell grows by a layer on every side as long as that is empty: as a cube until it touches something, and on
/// along it.
CellBox grown(const Occupancy& occupancy, const Cell& cell) {
    CellBox box{cell, {cell[0] + 1, cell[1] + 1, cell[2] + 1}};
    bool grows[3][2] = {{true, true}, {true, true}, {true, true}};
    for (bool any = true; any;) {
        any = false;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool up : {false, true}) {
                if (!grows[k][up]) continue;
                CellBox layer = box;
                if (up) layer.lower[k] = box.upper[k], layer.upper[k] = box.upper[k] + 1;
                else layer.upper[k] = box.lower[k], layer.lower[k] = box.lower[k] - 1;
                grows[k][up] =
                    layer.lower[k] >= 0 && layer.upper[k] <= occupancy.cells()[k] && occupancy.is_empty(layer);
                if (!grows[k][up]) continue;
                up ? ++box.upper[k] : --box.lower[k];
                any = true;
            }
        }
    }
    return box;
}

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Finds boxes for all cells of a grid.
class Grower {
public:
    Grower(const std::array<std::uint32_t, 3>& counts, const std::vector<SurveyedCell>& cells)
        : counts_{std::int32_t(counts[0]), std::int32_t(counts[1]), std::int32_t(counts[2])},
          stride_{1, std::size_t{counts[0]}, std::size_t{counts[0]} * counts[1]}, cells_(cells),
          occupancy_(counts_, cells) {
        for (std::size_t k = 0; k < 3; ++k) {
            GridBox below{{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}}, above = below;
            below.upper[k] = 0, above.lower[k] = float(counts[k]);
            add(below), add(above);
        }
        add({{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}});
        found_.box.assign(cells.size(), nothing);
    }
    ClearBoxes operator()() {
        for (const std::uint32_t i : widest_first()) {
            const Cell cell{std::int32_t(i % stride_[1]), std::int32_t(i % stride_[2] / stride_[1]),
                            std::int32_t(i / stride_[2])};
            const float cube = cells_[i].distance * 0.577f - 0.5f;  // half of its edge, and not quite that
            if (!take_from_neighbours(i, cell, std::max(cube, 0.0f)) && cells_[i].content.empty()) {
                found_.box[i] = float(found_.boxes.size() / 6);
                add(bounds_of(grown(occupancy_, cell)));
            }
        }
        return std::move(found_);
    }

private:
    static constexpr float nothing = 6;  ///< the box's number

    /// All cells, so that one finds the boxes of its wider neighbours; by halves of a cell's edge.
    std::vector<std::uint32_t> widest_first() const {
        const auto width = [](const SurveyedCell& cell) { return std::size_t(2 * std::min(cell.distance, 500.0f)); };
        std::array<std::uint32_t, 1001> wider{};  // cells that are, of each width
        for (const SurveyedCell& cell : cells_) ++wider[width(cell)];
        std::exclusive_scan(wider.rbegin(), wider.rend(), wider.rbegin(), 0u);
        std::vector<std::uint32_t> order(cells_.size());
        for (std::uint32_t i = 0; i < cells_.size(); ++i) order[wider[width(cells_[i])]++] = i;
        return order;
    }
    void add(const GridBox& box) {
        for (const auto& corner : {box.lower, box.upper})
            found_.boxes.insert(found_.boxes.end(), corner.begin(), corner.end());
    }

    /// The box of a neighbour that leaves most room around the cell's middle, `least` at least; false if there is none.
    bool take_from_neighbours(std::uint32_t i, const Cell& cell, float least) {
        bool found = false;
        for (std::size_t k = 0; k < 3; ++k) {
            for (const bool up : {false, true}) {
                if (cell[k] == (up ? counts_[k] - 1 : 0)) continue;
                const float box = found_.box[up ? i + stride_[k] : i - stride_[k]],
                            room = room_around(&found_.boxes[6 * std::size_t(box)], cell);
                if (room >= least) least = room, found_.box[i] = box, found = true;
            }
        }
        return found;
    }
    /// How far the bounds are from the middle of a cell; below 0 where it is outside.
    static float room_around(const float* bounds, const Cell& cell) {
        float least = infinity;
        for (std::size_t k = 0; k < 3; ++k) {
            const float middle = float(cell[k]) + 0.5f;
            least = std::min({least, middle - bounds[k], bounds[3 + k] - middle});
        }
        return least;
    }
    /// Of these cells, and in every direction as far as what lies in the next layer; where no cells follow as far as
    /// can be.
    GridBox bounds_of(const CellBox& cells) const {
        GridBox box;
        for (std::size_t k = 0; k < 3; ++k) box.lower[k] = float(cells.lower[k]), box.upper[k] = float(cells.upper[k]);
        for (std::size_t k = 0; k < 3; ++k) {
            box.lower[k] = -(cells.lower[k] > 0 ? reach(box, k, -1, cells.lower[k] - 1) : infinity);
            box.upper[k] = cells.upper[k] < counts_[k] ? reach(box, k, 1, cells.upper[k]) : infinity;
        }
        return box;
    }
    /// How far the box can be extended along axis k, up or down, into the layer of cells there: sign times the bound.
    float reach(const GridBox& box, std::size_t k, int sign, std::int32_t layer) const {
        constexpr float spare = 0.01f;  // for the roundings of those who look
        float bound = sign > 0 ? float(layer + 1) : -float(layer);
        Cell from, to;
        for (std::size_t j = 0; j < 3; ++j) {
            from[j] = j == k ? layer : std::max(0, std::int32_t(std::floor(std::max(box.lower[j], 0.0f))));
            to[j] = j == k ? layer + 1 : std::int32_t(std::ceil(std::min(box.upper[j], float(counts_[j]))));
        }
        for (std::int32_t z = from[2]; z < to[2]; ++z)
            for (std::int32_t y = from[1]; y < to[1]; ++y)
                for (std::int32_t x = from[0]; x < to[0]; ++x)
                    for (const GridBox& content :
                         cells_[std::size_t(z) * stride_[2] + std::size_t(y) * stride_[1] + std::size_t(x)].content)
                        if (overlap_beside(box, content, k))
                            bound = std::min(bound, (sign > 0 ? content.lower[k] : -content.upper[k]) - spare);
        return bound;
    }
    /// Whether boxes overlap along the axes other than k.
    static bool overlap_beside(const GridBox& a, const GridBox& b, std::size_t k) {
        for (std::size_t j = 0; j < 3; ++j)
            if (j != k && !(a.lower[j] <= b.upper[j] && b.lower[j] <= a.upper[j])) return false;
        return true;
    }

    const Cell counts_;
    const std::array<std::size_t, 3> stride_;
    const std::vector<SurveyedCell>& cells_;
    const Occupancy occupancy_;
    ClearBoxes found_;
};

}  // namespace

ClearBoxes grow_clear_boxes(const std::array<std::uint32_t, 3>& counts, const std::vector<SurveyedCell>& cells) {
    return Grower(counts, cells)();
}

}  // namespace kagero
