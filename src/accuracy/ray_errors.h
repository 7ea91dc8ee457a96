/// Errors of ray ends against reference ray ends.
#pragma once

#include "accuracy/sample_rays.h"
#include "rays/end_distance.h"
#include "render/percentiles.h"

namespace kagero {

/// Conditioning above which a ray is ill-conditioned. Errors of position and direction do not include such a ray. Its
/// pixel error is divided by conditioning / `conditioning_limit`, because one pixel near the ray shows a region many
/// pixels wide.
inline constexpr double conditioning_limit = 1e3;

/// Reference ends of the sample rays.
struct ReferenceRays {
    std::vector<RayEnd> ends;
    /// Conditioning of each ray: the angle between the end of the ray and that of a neighbouring ray, divided by the
    /// angle between their starts. The angle between the ends is that between the directions or between the end points
    /// as seen from the camera, whichever is greater. Each ray has two neighbours; the greater conditioning counts.
    std::vector<double> conditioning;
    /// For each ray: true if two methods agree on its status and object, and the status is `hit`, `escaped` or
    /// `captured`.
    std::vector<bool> confirmed;
};

/// Sets ReferenceRays::confirmed from the ends of the same rays by another method. Returns the number of rays that are
/// not confirmed.
std::size_t confirm(ReferenceRays& reference, const std::vector<RayEnd>& confirming);

/// Returns the pixel error of any two ray ends: `distance_in_pixels` if both have the same status and object. The
/// result is zero if both rays are captured or cut off. It is NaN if status or object differ, or if the status is
/// `step_limit` or `failed`.
double pixel_error(const Plan& plan, const RayEnd& expected, const RayEnd& actual);

/// Returns a ray end of `trace` with its position in the coordinates of the Hamiltonian instead of those of the scene
/// file.
RayEnd to_hamiltonian_coordinates(const Plan& plan, RayEnd end);

/// Errors of the sample rays in one run, relative to the reference. Rays whose status or object differs from the
/// reference are counted only in `flips`. Captured rays have no end point and no error.
struct RayErrors {
    std::uint64_t compared = 0;                  ///< Number of well-conditioned rays that were compared.
    std::uint64_t flips = 0;                     ///< Number of rays whose status or object differs from the reference.
    std::uint64_t compared_ill_conditioned = 0;  ///< Number of ill-conditioned rays that were compared.
    Percentiles position;                        ///< Distance of the end points, well-conditioned rays; scene units.
    Percentiles direction;           ///< Angle between the directions at the ends, well-conditioned rays; radians.
    Percentiles pixels;              ///< Pixel error of all compared rays; scaled as described at conditioning_limit.
    double above_quarter_pixel = 0;  ///< Share of the errors in `pixels` that exceed 0.25.
    Percentiles ill_conditioned_pixels;  ///< Pixel error divided by conditioning, ill-conditioned rays only.
};

/// Compares ray ends with the reference. Positions are in scene coordinates, as `trace` returns them.
RayErrors compare_rays(const Plan& plan, const ReferenceRays& reference, const std::vector<RayEnd>& ends);

/// Returns ReferenceRays::conditioning. `ends` are the ends of the sample rays; `right` and `below` are the ends of
/// their neighbours.
std::vector<double> conditioning_of(const Plan& plan, const SampleRays& sample, const std::vector<RayEnd>& ends,
                                    const std::vector<RayEnd>& right, const std::vector<RayEnd>& below);

}  // namespace kagero
