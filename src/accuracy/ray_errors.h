/// Ends of rays against the ends they should have had.
#pragma once

#include "accuracy/sample_rays.h"
#include "render/spread.h"

namespace kagero {

/// A ray that turns its neighbours apart by more than this multiplies every error by as much. It is counted apart, and
/// in pixels by the error over that excess: a pixel beside it spans thousands of its size, and by how many of those an
/// end is off is not seen.
inline constexpr double ill_conditioned = 1e3;

/// The ends that rays should have.
struct ReferenceRays {
    std::vector<RayEnd> ends;
    std::vector<double>
        conditioning;  ///< greatest angle between a ray's end and its neighbours', over that between their starts
    std::vector<bool> decided;         ///< two methods agree on how the ray ends, and it does
};

/// Whether there is something to see at the end of a ray.
bool has_end(const RayEnd& end);

/// Whether the direction tells what is seen at the end of a ray, and not the place.
bool seen_by_direction(const Plan& plan, const RayEnd& end);

/// How large a pixel of the film is where a ray ends: a length where it hits, else an angle.
double pixel_at(const Plan& plan, const RayEnd& end);

/// How far what is seen at the end of a ray is from where it should be, in pixels of the film: a point by its distance,
/// the sky by its direction (by the end point where a camera's rays are parallel). Ends of one class, in the
/// coordinates of the Hamiltonian, as kernels write them.
double pixels_apart(const Plan& plan, const RayEnd& should, const RayEnd& is);

/// The same for any ends: zero where both are captured, not a number where they differ in class or there is nothing to
/// see.
double pixel_error(const Plan& plan, const RayEnd& should, const RayEnd& is);

/// From the scene's coordinates and unit, in which `trace` tells ends, to those of the Hamiltonian.
RayEnd in_space(const Plan& plan, RayEnd end);

/// Errors of one way of tracing the sample. Rays that end otherwise than they should are `flips` and enter nothing
/// else; rays that are captured have no end to compare.
struct RayErrors {
    std::uint64_t compared = 0, flips = 0, ill = 0;
    Spread position;                 ///< of the end point, scene units
    Spread direction;                ///< between the ends' directions, radians
    Spread pixels;  ///< where the end is seen, in pixels of the film; of ill-conditioned rays too, see below
    double above_quarter_pixel = 0;  ///< share of those
    Spread ill_pixels;               ///< of ill-conditioned rays: pixels over conditioning
};

/// True when both rays ended in the same way, and on the same object if on any.
bool same_class(const RayEnd& a, const RayEnd& b);

/// Positions of `ends` are scene coordinates.
RayErrors compare_rays(const Plan& plan, const ReferenceRays& reference,
                       const std::vector<RayEnd>& ends);

/// conditioning of ReferenceRays, from the ends of the sample's rays and of those turned aside.
std::vector<double> conditioning_of(const Plan& plan, const SampleRays& sample, const std::vector<RayEnd>& ends,
                                    const std::vector<RayEnd>& right, const std::vector<RayEnd>& below);

}  // namespace kagero
