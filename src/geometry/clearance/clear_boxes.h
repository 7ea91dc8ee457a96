/// Boxes that contain no surface, found for the cells of a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace kagero {

/// Clear boxes of a grid, in the memory layout that ClearanceGrid requires.
struct ClearBoxes {
    std::vector<float> box_index;  ///< For each cell: index of its clear box in `boxes`; x varies fastest.
    /// Six numbers per box: lower x, y, z and upper x, y, z. The coordinates are relative to the lower corner of the
    /// grid; the unit along each axis is the edge of a cell. The first six boxes are the half spaces beyond the grid's
    /// faces −x, +x, −y, +y, −z and +z. The seventh box is empty.
    std::vector<float> boxes;
};

/// Box in the coordinates of ClearBoxes::boxes.
struct GridBox {
    std::array<float, 3> lower, upper;
};

/// Result of the search for surfaces near one cell.
struct CellClearance {
    /// Lower bound on the distance from the cell's centre to the nearest surface. It is measured in coordinates in
    /// which the cells are cubes with edges of length 1.
    float distance;
    /// Boxes that together contain all parts of surfaces in the cell; empty if the cell contains no surface.
    std::vector<GridBox> content;
};

/// Finds clear boxes for a grid with `counts` cells along x, y and z. The clear box of a cell contains the cell's
/// centre. On every side, it extends at least about as far from the centre as the largest axis-aligned cube inside the
/// sphere of radius `CellClearance::distance` around the centre. A cell gets the empty box if no clear box contains its
/// centre.
ClearBoxes grow_clear_boxes(const std::array<std::uint32_t, 3>& counts, const std::vector<CellClearance>& cells);

}  // namespace kagero
