/// Boxes that contain no surface, found for the cells of a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kagero {

/// Clear boxes in the layout of ClearanceGrid.
struct ClearBoxes {
    std::vector<float> box_index;  ///< For each cell: index of its clear box in `boxes`; x varies fastest.
    /// Six numbers per box: lower x, y, z and upper x, y, z, in cells from the grid's lower corner. The first six boxes
    /// are the half spaces beyond the grid's faces −x, +x, −y, +y, −z and +z. The seventh box is empty.
    std::vector<float> boxes;
};

/// Box whose corners are given in cells from the grid's lower corner.
struct GridBox {
    std::array<float, 3> lower, upper;
};

/// Result of the surface search for one grid cell; lengths are in cell edges.
struct CellClearance {
    float distance;  ///< Lower bound on the distance from the cell's centre to the nearest surface.
    /// Boxes that together contain all parts of surfaces in the cell; empty if the cell contains no surface.
    std::vector<GridBox> content;
};

/// Finds clear boxes for a grid with `counts` cells along x, y and z. The clear box of a cell contains the cell's
/// centre. On every side, it extends at least about as far from the centre as the largest axis-aligned cube inside the
/// sphere of radius `CellClearance::distance`. A cell gets the empty box if no clear box contains its centre.
ClearBoxes grow_clear_boxes(const std::array<std::uint32_t, 3>& counts, const std::vector<CellClearance>& cells);

}  // namespace kagero
