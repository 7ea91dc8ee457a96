/// Boxes without a surface, grown from the cells of a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kagero {

/// Boxes as ClearanceGrid has them.
struct ClearBoxes {
    std::vector<float> box;    ///< of each cell, x fastest: its number
    std::vector<float>
        boxes;  ///< six numbers each; the first six boxes are half spaces beyond the grid, the next one holds nothing
};

/// A box, in edges of a cell from the grid's first corner.
struct GridBox {
    std::array<float, 3> lower, upper;
};

/// What surfaces there are around a cell's middle, and in the cell.
struct SurveyedCell {
    float distance;                ///< of the nearest one from the middle, at least; in edges of a cell
    std::vector<GridBox> content;  ///< that holds all that lies in the cell
};

/// Every cell whose middle is clear gets a box in which surfaces are no nearer to it, along any axis, than in the
/// largest cube that fits into its distance.
ClearBoxes grow_clear_boxes(const std::array<std::uint32_t, 3>& counts, const std::vector<SurveyedCell>& cells);

}  // namespace kagero
