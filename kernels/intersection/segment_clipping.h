/// Limits the segments of a query to the part that Embree must intersect.
#pragma once

#include "kernels/intersection/segment_query.h"
#include "kernels/intersection/surface.h"

#include <algorithm>
#include <cmath>

namespace kagero {

/// In Embree's coordinates: a segment with an absolute coordinate of at least this value is clipped before a query, to
/// the cube with this edge around the origin.
inline constexpr float clip_size = 8;

/// For segments that begin outside the escape sphere, moves the start of the query to their entry into the sphere.
template <class V, int W = lane_count<V>>
void skip_outside_escape_sphere(const V& radius, const Vec3<V>& a, const Vec3<V>& b, Segments<W>& segments) {
    using S = ScalarOf<V>;
    const MaskOf<V> beyond = dot(a, a) > radius * radius;
    if (!any(beyond)) return;
    const V entry = chord_fraction(sphere_level_set(radius), a, b, V(S(0)));
    float entries[W];
    to_floats(select(beyond & (entry > V(S(0))) & (entry < V(S(1))), entry, V(S(0))), entries);
    for (int i = 0; i < W; ++i) segments.near[i] = std::max(segments.near[i], entries[i]);
}

/// Clips the queried part of a → b in lane i to the cube of edge `clip_size` around the origin of Embree's
/// coordinates, in double precision. Returns false if the segment misses the cube.
template <class V, int W = lane_count<V>>
bool clip(const Geometry& geometry, const Vec3<V>& a, const Vec3<V>& b, int i, Segments<W>& segments, V& begin,
          V& length) {
    using S = ScalarOf<V>;
    const double start[3] = {double(get_lane(a.x, i)), double(get_lane(a.y, i)), double(get_lane(a.z, i))};
    const double end[3] = {double(get_lane(b.x, i)), double(get_lane(b.y, i)), double(get_lane(b.z, i))};
    const double old_begin = double(get_lane(begin, i)),
                 near = old_begin + double(get_lane(length, i)) * double(segments.near[i]);
    double enter = old_begin, leave = old_begin + double(get_lane(length, i)), org[3], dir[3];
    for (int k = 0; k < 3; ++k) {
        org[k] = (start[k] - geometry.shift[k]) * geometry.scale;
        dir[k] = (end[k] - start[k]) * geometry.scale;
        const double half = 0.5 * double(clip_size), u = (-half - org[k]) / dir[k], v = (half - org[k]) / dir[k];
        if (dir[k] == 0 && std::abs(org[k]) > half) return false;
        if (dir[k] != 0) {
            enter = std::max(enter, std::min(u, v));
            leave = std::min(leave, std::max(u, v));
        }
    }
    if (!(enter < leave)) return false;
    const double clipped_length = leave - enter;
    set_lane(begin, i, S(enter));
    set_lane(length, i, S(clipped_length));
    segments.near[i] = float(std::clamp((near - enter) / clipped_length, 0.0, 1.0));
    if (geometry.has_spheres)
        for (int k = 0; k < 3; ++k) {
            segments.exact_org[k][i] = start[k] + enter * (end[k] - start[k]);
            segments.exact_dir[k][i] = clipped_length * (end[k] - start[k]);
        }
    for (int k = 0; k < 3; ++k) {
        segments.org[k][i] = float(org[k] + enter * dir[k]);
        segments.dir[k][i] = float(clipped_length * dir[k]);
    }
    return true;
}

}  // namespace kagero
