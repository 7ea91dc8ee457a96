/// Parts of the shading of many pixels that the kernels compute, with one array per quantity. Part of the binary
/// interface (abi.h).
#pragma once

#include <cstdint>

namespace kagero {

struct ShadedCell;

/// Numbers of elements are multiples of this number, so that arrays consist of whole vectors.
inline constexpr std::uint32_t shading_lanes = 16;

/// Blocks of 2 × 2 rays that escape to the same sky, and their footprints (src/appearance/footprint.h). The arrays have
/// one element for each block.
struct SkyBlocks {
    std::uint32_t count;
    /// Components of the directions of the upper left, upper right, lower left and lower right rays.
    const double* directions[4][3];
    double *major[3], *minor[3];  ///< Receive the axes of the footprints.
};

/// Points on an equirectangular sky with their footprints, and what a lookup needs. The arrays have one element for
/// each point.
struct SkyPoints {
    std::uint32_t count;
    double zero[3], east[3], up[3];  ///< Axes of the sky (src/appearance/chart.h).
    double texel;                    ///< Size of the texels of the sky's image, in radians; 0 without an image.
    const double* direction[3];      ///< Components of the directions, which are unit vectors.
    const double *major[3], *minor[3];  ///< Axes of the footprints.
    double *u, *v;                      ///< Receive texture coordinates.
    double* by_major[2];  ///< Receive the differences of u and v over the major axis.
    double* by_minor[2];  ///< The same for the minor axis; used only without an image.
    // Used only with an image:
    double *level, *probes;  ///< Receive the members of Probes (src/appearance/pyramid.h). If `level` is
                             ///< null, they are not computed: they are those of an earlier call.
    double* bend;            ///< Receives the deviation of u and v from straight lines along the major axis; the unit
                             ///< is a quarter of a texel.
};

/// Integrals of Planck's law with three weights, as sums over equidistant values of 1/λ.
struct PlanckSums {
    std::uint32_t count;   ///< Number of temperatures.
    std::uint32_t nodes;   ///< Number of values of 1/λ.
    double first, step;    ///< The least value of 1/λ and the difference between values, times hc/k, in kelvin.
    const double* weights[3];
    const double* kelvin;  ///< Temperatures.
    double* sums[3];       ///< Receive the sums over the nodes of weight / (exp(node / temperature) − 1).
};

/// Computes each of them. No result for an element depends on the other elements.
struct ShadingFunctions {
    void (*sky_footprints)(const SkyBlocks*);
    void (*sky_points)(const SkyPoints*);
    void (*planck_sums)(const PlanckSums*);
    void (*shade_cell)(const ShadedCell*);
};

}  // namespace kagero
