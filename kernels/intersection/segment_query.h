/// Intersects straight segments with the scene by Embree. This is the only file that uses Embree's packets. The
/// differences between Embree 3 and 4 are confined to this file and cmake/dependencies.cmake.
#pragma once

#include "kernels/assertion.h"
#include "kernels/intersection/query_context.h"
#include "kernels/simd/bits.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <rtcore.h>

namespace kagero {

/// Number of rays per Embree packet: the native width of the instruction set.
#if defined(__AVX512F__)
inline constexpr int embree_width = 16;
using EmbreePacket = RTCRayHit16;
#elif defined(__AVX2__)
inline constexpr int embree_width = 8;
using EmbreePacket = RTCRayHit8;
#else
inline constexpr int embree_width = 4;
using EmbreePacket = RTCRayHit4;
#endif

/// Mask with one bit for each ray of an Embree packet.
inline constexpr std::uint64_t all_in_packet = (std::uint64_t(1) << embree_width) - 1;

/// W segments org + t·dir with t in [near, 1], in Embree's coordinates (see struct Geometry), and their first
/// intersections.
template <int W>
struct Segments {
    float org[3][W], dir[3][W], near[W];
    /// The same segments in double precision, relative to `space.center`. Needed if the scene has spheres.
    alignas(64) double exact_org[3][W], exact_dir[3][W];
    double margin = 0;                    ///< ExactSegments::margin.
    std::uint32_t ignored[W];             ///< ExactSegments::ignored.
    // Results, valid in the lanes that the query returns: the parameter t of the intersection, and the indices of its
    // surface and primitive.
    float t[W];
    std::uint32_t surface[W] = {}, primitive[W] = {};

    ExactSegments exact() const {
        return {{exact_org[0], exact_org[1], exact_org[2]},
                {exact_dir[0], exact_dir[1], exact_dir[2]},
                margin,
                ignored};
    }
};

/// Triangles that a query ignores: for each of `lanes`, its own one.
struct IgnoredTriangles {
    std::uint64_t lanes = 0;
    const std::uint32_t *surface = nullptr, *primitive = nullptr;

    bool contains(unsigned lane, std::uint32_t its_surface, std::uint32_t its_primitive) const {
        return ((lanes >> lane) & 1) != 0 && its_surface == surface[lane] && its_primitive == primitive[lane];
    }
};

namespace detail {

/// Rejects the intersections of a query with its ignored triangles. Embree calls this function for the rays of a packet
/// that may hit one triangle.
inline void reject_ignored_triangles(const RTCFilterFunctionNArguments* a) {
    const auto& ignored = *static_cast<const IgnoredTriangles*>(static_cast<const QueryContext*>(a->context)->user);
    for (unsigned k = 0; k < a->N; ++k) {
        if (a->valid[k] != 0 && ignored.contains(RTCRayN_id(a->ray, a->N, k), RTCHitN_geomID(a->hit, a->N, k),
                                                 RTCHitN_primID(a->hit, a->N, k)))
            a->valid[k] = 0;
    }
}

/// Intersects one ray. A non-null `filter` may reject intersections; it reads `user` from the query context.
inline void intersect1(RTCScene scene, RTCRayHit* ray, const ExactSegments* segments,
                       RTCFilterFunctionN filter = nullptr, const void* user = nullptr) {
    QueryContext context;
    context.segments = segments;
    context.hit_filter = filter;
    context.user = user;
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(&context);
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    if (filter) {
        arguments.flags = RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER;
        arguments.filter = filter;
    }
    arguments.context = &context;
    rtcIntersect1(scene, ray, &arguments);
#else
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    context.filter = filter;
    rtcIntersect1(scene, &context, ray);
#endif
}

/// Intersects one packet; rays with valid[i] = 0 are ignored. `has_ignored` is true if a ray of the packet ignores a
/// triangle. Spheres are never ignored, so they need no filter.
inline void intersect(const int* valid, RTCScene scene, EmbreePacket* rays, const ExactSegments* segments,
                      const IgnoredTriangles& ignored, bool has_ignored) {
    QueryContext context;
    context.segments = segments;
    context.hit_filter = nullptr;
    context.user = &ignored;
    const RTCFilterFunctionN filter = has_ignored ? reject_ignored_triangles : nullptr;
#if RTC_VERSION_MAJOR >= 4
    rtcInitRayQueryContext(&context);
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    if (filter) {
        arguments.flags = RTCRayQueryFlags(RTC_RAY_QUERY_FLAG_COHERENT | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);
        arguments.filter = filter;
    }
    arguments.context = &context;
    const auto call = [&](auto function) { function(valid, scene, rays, &arguments); };
#else
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    context.filter = filter;
    const auto call = [&](auto function) { function(valid, scene, &context, rays); };
#endif
#if defined(__AVX512F__)
    call(rtcIntersect16);
#elif defined(__AVX2__)
    call(rtcIntersect8);
#else
    call(rtcIntersect4);
#endif
}

/// Writes segment i of `s` into an Embree ray. `at(field)` returns a reference to the ray's element of the field:
/// `field` itself for a single ray, or one element of its array for a packet.
inline void set_ray(auto& ray, auto&& at, const auto& s, int i) {
    at(ray.org_x) = s.org[0][i];
    at(ray.org_y) = s.org[1][i];
    at(ray.org_z) = s.org[2][i];
    at(ray.dir_x) = s.dir[0][i];
    at(ray.dir_y) = s.dir[1][i];
    at(ray.dir_z) = s.dir[2][i];
    at(ray.tnear) = s.near[i];
    at(ray.tfar) = 1.0f;
    at(ray.time) = 0;
    at(ray.mask) = 0xffffffffu;
    at(ray.id) = unsigned(i);
    at(ray.flags) = 0;
}

/// Queries the active segments one by one. `intersect_lane(i, ray)` intersects the ray of lane i. Returns the lanes
/// that hit.
template <int W, class IntersectLane>
std::uint64_t query_singly(Segments<W>& s, std::uint64_t active, const IntersectLane& intersect_lane) {
    std::uint64_t hits = 0;
    for (const int i : lanes_in(active)) {
        RTCRayHit r;
        set_ray(r.ray, [](auto& field) -> auto& { return field; }, s, i);
        r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        intersect_lane(i, &r);
        if (r.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
        hits |= std::uint64_t(1) << i;
        s.t[i] = r.ray.tfar;
        s.surface[i] = r.hit.geomID;
        s.primitive[i] = r.hit.primID;
    }
    return hits;
}

/// Queries lanes [first, first + embree_width) as one packet. Returns the lanes that hit. Inactive lanes get an empty
/// ray with finite coordinates, because Embree ignores `valid` for packet widths that are not native.
template <int W>
std::uint64_t query_packet(RTCScene scene, Segments<W>& s, std::uint64_t active, int first,
                           const IgnoredTriangles& ignored) {
    alignas(64) EmbreePacket r;
    alignas(64) int valid[embree_width];
    for (int k = 0; k < embree_width; ++k) set_ray(r.ray, [k](auto& field) -> auto& { return field[k]; }, s, first + k);
    std::fill_n(r.hit.geomID, embree_width, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(r.hit.instID[0], embree_width, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(valid, embree_width, -1);
    for (const int k : lanes_in(~(active >> first) & all_in_packet)) {
        valid[k] = 0;
        r.ray.org_x[k] = r.ray.org_y[k] = r.ray.org_z[k] = 0;
        r.ray.dir_x[k] = 1;
        r.ray.dir_y[k] = r.ray.dir_z[k] = 0;
        r.ray.tnear[k] = 1;
        r.ray.tfar[k] = -std::numeric_limits<float>::infinity();
    }
    const ExactSegments exact = s.exact();
    intersect(valid, scene, &r, &exact, ignored, (ignored.lanes & active) != 0);
    std::copy_n(r.ray.tfar, embree_width, s.t + first);
    std::copy_n(r.hit.geomID, embree_width, s.surface + first);
    std::copy_n(r.hit.primID, embree_width, s.primitive + first);
    std::uint64_t hits = 0;
    for (int k = 0; k < embree_width; ++k)
        hits |= std::uint64_t(r.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID) << (first + k);
    hits &= active;
    return hits;
}

}  // namespace detail

/// Greatest number of active segments in an Embree packet that are queried one by one. One packet query costs about as
/// much as this number of single queries.
inline constexpr int single_query_limit = 3;

/// Returns true if Embree accepts the segment. Embree terminates the process if a coordinate is not finite, if its
/// magnitude exceeds about 1.8e18, or if `near` is negative.
template <int W>
bool is_legal_segment(const Segments<W>& s, int lane) {
    constexpr float largest = 1.8e18f;
    bool legal = s.near[lane] >= 0;
    for (int k = 0; k < 3; ++k)
        legal = legal && std::abs(s.org[k][lane]) < largest && std::abs(s.dir[k][lane]) < largest;
    return legal;
}

/// Queries the active segments, which must be legal (`is_legal_segment`). Returns the lanes that hit.
template <int W>
std::uint64_t query(void* embree_scene, Segments<W>& s, std::uint64_t active, const IgnoredTriangles& ignored = {}) {
    for ([[maybe_unused]] const int i : lanes_in(active))
        KAGERO_ASSERT(is_legal_segment(s, i));
    const auto scene = static_cast<RTCScene>(embree_scene);
    const ExactSegments exact = s.exact();
    const auto intersect_lane = [&](int i, RTCRayHit* ray) {
        const bool has_ignored = ((ignored.lanes >> i) & 1) != 0;
        detail::intersect1(scene, ray, &exact, has_ignored ? detail::reject_ignored_triangles : nullptr, &ignored);
    };
    if constexpr (W % embree_width == 0) {
        std::uint64_t hits = 0;
        for (int first = 0; first < W; first += embree_width) {
            const std::uint64_t in_packet = active & (all_in_packet << first);
            if (__builtin_popcountll(in_packet) <= single_query_limit)
                hits |= detail::query_singly(s, in_packet, intersect_lane);
            else hits |= detail::query_packet(scene, s, in_packet, first, ignored);
        }
        return hits;
    } else {
        return detail::query_singly(s, active, intersect_lane);
    }
}

/// Queries the active segments one by one. Only intersections for which `accepts(lane, surface, primitive, t)` returns
/// true count as hits. Returns the lanes that hit.
template <int W, class Accepts>
std::uint64_t query_filtered(void* embree_scene, Segments<W>& s, std::uint64_t active, const Accepts& accepts) {
    struct Candidate {
        const Accepts& accepts;
        int lane;
    };
    const RTCFilterFunctionN filter = [](const RTCFilterFunctionNArguments* a) {
        const auto* context = static_cast<const QueryContext*>(a->context);
        const auto& candidate = *static_cast<const Candidate*>(context->user);
        if (a->valid[0] != 0 && !candidate.accepts(candidate.lane, RTCHitN_geomID(a->hit, 1, 0),
                                                   RTCHitN_primID(a->hit, 1, 0), RTCRayN_tfar(a->ray, 1, 0)))
            a->valid[0] = 0;
    };
    const ExactSegments exact = s.exact();
    return detail::query_singly(s, active, [&](int i, RTCRayHit* ray) {
        const Candidate candidate{accepts, i};
        detail::intersect1(static_cast<RTCScene>(embree_scene), ray, &exact, filter, &candidate);
    });
}

/// Shift of a segment that exceeds the rounding errors of a query, in Embree's coordinates.
inline constexpr float query_shift = 1e-6f;

/// Queries the active segments like `query_filtered`, and again shifted to all sides. Embree's floats may assign a
/// segment close to an edge to the wrong triangle only; one of the shifted segments finds the other triangle. `accepts`
/// must not depend on the shift. The first of all accepted intersections counts. Returns the lanes that hit.
template <int W, class Accepts>
std::uint64_t query_around(void* embree_scene, Segments<W>& s, std::uint64_t active, const Accepts& accepts) {
    std::uint64_t hits = query_filtered(embree_scene, s, active, accepts);
    for (int shift = 0; shift < 6; ++shift) {
        Segments<W> shifted = s;
        for (int i = 0; i < W; ++i) shifted.org[shift / 2][i] += shift % 2 ? -query_shift : query_shift;
        const std::uint64_t found = query_filtered(embree_scene, shifted, active, accepts);
        for (const int i : lanes_in(found)) {
            if (((hits >> i) & 1) != 0 && s.t[i] <= shifted.t[i]) continue;
            s.t[i] = shifted.t[i];
            s.surface[i] = shifted.surface[i];
            s.primitive[i] = shifted.primitive[i];
        }
        hits |= found;
    }
    return hits;
}

}  // namespace kagero
