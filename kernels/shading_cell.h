/// Shading of a square cell of pixels whose rays end alike, from what is known at 3 × 3 nodes. Part of the binary
/// interface (abi.h).
#pragma once

#include <cstddef>
#include <cstdint>

namespace kagero {

/// An image, or a copy of it with a lower resolution: RGB, row by row from the top.
struct ImageLevel {
    const void* texels;
    std::int32_t width, height;
};

/// An image and its copies of decreasing resolution.
struct ImageLevels {
    enum class Components : std::uint32_t { floats, bytes, words };
    Components components;          ///< Components of level 0. All other levels consist of floats.
    bool repeats_x, repeats_y;      ///< True if the image repeats beyond its edges. Otherwise, its edges continue.
    const float* linear;            ///< The linear value of each code, if the components are bytes or words.
    std::uint32_t count;            ///< Number of levels.
    const ImageLevel* levels;       ///< Level 0 is the image.
};

/// A checker whose squares have edges of length 1. Squares with an even sum of indices are bright.
struct CheckerPattern {
    double lower[2], upper[2];  ///< Parts of a footprint outside of this rectangle are ignored.
};

/// A quantity in a cell: a biquadratic function of the position in the cell, given by its values at 3 × 3 nodes, row by
/// row. The nodes are at the distances 0, edge / 2 and edge from the first pixel.
using CellNodes = double[9];

/// A cell of pixels whose colours are the product of a pattern and a light.
struct ShadedCell {
    std::uint32_t edge;  ///< Number of pixels along an edge: a power of two, at least 8.
    /// Position in the pattern minus `base`: in texels of level 0 from the middle of the first texel of the upper row,
    /// or in squares of a checker. `base` consists of integers, for a checker of even ones.
    CellNodes x, y;
    double base[2];
    ImageLevels image;       ///< No levels without an image.
    bool has_checker;
    CheckerPattern checker;  ///< Used only if `has_checker` is true.
    double color[3];         ///< Colour without an image.
    /// Sides of a texel of level 0 on the equator of a sphere, in radians, and the size of a texel for the filter. All
    /// three are 0 if the image does not cover a sphere; a texel is then the unit of length.
    double sphere_texel_x, sphere_texel_y, sphere_texel;
    CellNodes sine, cosine;   ///< Sine and cosine of the latitude, for an image on a sphere.
    std::uint32_t lights;     ///< Number of components of the light: 0 (no factor), 1 (the same for all colours) or 3.
    CellNodes light[3];
    float* colors;            ///< Receives the colours from pixel (x0, y0) of the cell to pixel (x1 − 1, y1 − 1).
    std::size_t row_length;   ///< Distance of rows in `colors`, in floats.
    std::uint32_t x0, y0, x1, y1;
};

}  // namespace kagero
