/// Data that a query passes to the callbacks of Embree: the intersection of spheres and the filters of hits.
#pragma once

#include "kernels/surfaces.h"

#include <cstdint>

#include <rtcore.h>

namespace kagero {

/// The segments org + t·dir of a query in double precision, relative to `space.center`. RTCRay::id is the index of the
/// segment.
struct ExactSegments {
    const double *org[3], *dir[3];
    /// Greatest distance of the path of a ray from its segment. A sphere that is at most this far away counts as hit,
    /// at the point of the segment nearest to its centre; the path then decides.
    double margin;
    /// For each segment, a sphere that its ray has just passed, or `no_surface`: it counts as hit only if the segment
    /// ends inside. Read only if `margin` > 0.
    const std::uint32_t* ignored;
};
/// Greatest margin, in Embree's coordinates.
inline constexpr double greatest_margin = 1e-4;

/// Context of a query.
#if RTC_VERSION_MAJOR >= 4
struct QueryContext : RTCRayQueryContext {
#else
struct QueryContext : RTCIntersectContext {
#endif
    const ExactSegments* segments;
    RTCFilterFunctionN hit_filter;  ///< Filter of this query; null if all hits are accepted. Reads `user`.
    const void* user;
};

}  // namespace kagero
