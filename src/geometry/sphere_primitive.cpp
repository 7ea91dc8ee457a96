#include "geometry/sphere_primitive.h"

#include "kernels/intersection/query_context.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kagero {
namespace {

void bounds_of_sphere(const RTCBoundsFunctionArguments* arguments) {
    const auto& sphere = *static_cast<const SpherePrimitive*>(arguments->geometryUserPtr);
    double lower[3], upper[3];
    for (int k = 0; k < 3; ++k) {
        const double center = (sphere.surface.center[k] - sphere.shift[k]) * sphere.scale,
                     reach = sphere.surface.radius * sphere.scale + 2 * greatest_margin;
        lower[k] = center - reach;
        upper[k] = center + reach;
    }
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = float(lower[0]);
    bounds.lower_y = float(lower[1]);
    bounds.lower_z = float(lower[2]);
    bounds.upper_x = float(upper[0]);
    bounds.upper_y = float(upper[1]);
    bounds.upper_z = float(upper[2]);
}

/// Values of t at which a segment org + t·dir may hit a sphere, in ascending order.
struct Candidates {
    std::array<double, 2> t{};
    int count = 0;
    void add(double value) { t[std::size_t(count++)] = value; }
};

/// Returns the values of t from `near` to `far` at which the segment org + t·dir meets the sphere. If it passes the
/// sphere within `margin`, returns the t of the point nearest to the centre. `org` is relative to the centre.
Candidates intersections(const double (&org)[3], const double (&dir)[3], double radius, double margin, double near,
                         double far) {
    const double length2 = dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2];
    const double middle = -(org[0] * dir[0] + org[1] * dir[1] + org[2] * dir[2]) / length2;
    double nearest2 = 0;  // squared distance of the line from the centre
    for (int k = 0; k < 3; ++k) {
        const double x = org[k] + middle * dir[k];
        nearest2 += x * x;
    }
    Candidates candidates;
    const double half2 = (radius * radius - nearest2) / length2;
    if (half2 >= 0) {
        const double half = std::sqrt(half2);
        for (const double t : {middle - half, middle + half})
            if (t >= near && t <= far) candidates.add(t);
    } else if (middle >= near && middle <= far && nearest2 <= (radius + margin) * (radius + margin)) {
        candidates.add(middle);
    }
    return candidates;
}

/// Returns true if the end of the segment org + t·dir, at t = 1, is outside of the sphere.
bool ends_outside(const double (&org)[3], const double (&dir)[3], double radius) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += (org[k] + dir[k]) * (org[k] + dir[k]);
    return square > radius * radius;
}

/// Calls the filter of a query with one ray, for a hit at its current end. Returns true if the filter accepts the hit.
bool is_accepted(const RTCIntersectFunctionNArguments* arguments, RTCFilterFunctionN filter) {
    RTCHit hit{};
    hit.geomID = arguments->geomID;
    hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    int valid = -1;
    RTCFilterFunctionNArguments filtered{};
    filtered.valid = &valid;
    filtered.geometryUserPtr = arguments->geometryUserPtr;
    filtered.context = arguments->context;
    filtered.ray = RTCRayHitN_RayN(arguments->rayhit, arguments->N);
    filtered.hit = reinterpret_cast<RTCHitN*>(&hit);
    filtered.N = 1;
    filter(&filtered);
    return valid != 0;
}

void intersect_sphere(const RTCIntersectFunctionNArguments* arguments) {
    const Surface& sphere = static_cast<const SpherePrimitive*>(arguments->geometryUserPtr)->surface;
    const auto& context = *static_cast<const QueryContext*>(arguments->context);
    const ExactSegments& segments = *context.segments;
    const unsigned n = arguments->N;
    RTCRayN* ray = RTCRayHitN_RayN(arguments->rayhit, n);
    RTCHitN* hit = RTCRayHitN_HitN(arguments->rayhit, n);
    for (unsigned i = 0; i < n; ++i) {
        if (arguments->valid[i] == 0) continue;
        const unsigned segment = RTCRayN_id(ray, n, i);
        double org[3], dir[3];
        for (int k = 0; k < 3; ++k) {
            org[k] = segments.org[k][segment] - sphere.center[k];
            dir[k] = segments.dir[k][segment];
        }
        const bool is_ignored = segments.margin > 0 && segments.ignored[segment] == arguments->geomID;
        if (is_ignored && ends_outside(org, dir, sphere.radius)) continue;
        float& far = RTCRayN_tfar(ray, n, i);
        const float old_far = far;
        const Candidates candidates = intersections(org, dir, sphere.radius, segments.margin,
                                                    double(RTCRayN_tnear(ray, n, i)), double(old_far));
        bool is_hit = false;
        for (int k = 0; k < candidates.count && !is_hit; ++k) {
            far = std::min(float(candidates.t[std::size_t(k)]), old_far);
            is_hit = !context.hit_filter || is_accepted(arguments, context.hit_filter);
        }
        if (!is_hit) {
            far = old_far;
            continue;
        }
        RTCHitN_geomID(hit, n, i) = arguments->geomID;
        RTCHitN_primID(hit, n, i) = 0;
    }
}

}  // namespace

RTCGeometry sphere_geometry(RTCDevice device, SpherePrimitive& sphere) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, 1);
    rtcSetGeometryUserData(geometry, &sphere);
    rtcSetGeometryBoundsFunction(geometry, bounds_of_sphere, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect_sphere);
    return geometry;
}

}  // namespace kagero
