#include "geometry/sphere_primitive.h"

#include "kernels/intersection/query_context.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

/// Returns the least t from `near` to `far` at which the segment org + t·dir meets the sphere. If it passes the sphere
/// within `margin`, returns the t of the point nearest to the centre. Returns NaN if there is no such t. `org` is
/// relative to the centre of the sphere.
double first_intersection(const double (&org)[3], const double (&dir)[3], double radius, double margin, double near,
                          double far) {
    const double length2 = dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2];
    const double middle = -(org[0] * dir[0] + org[1] * dir[1] + org[2] * dir[2]) / length2;
    double nearest2 = 0;  // squared distance of the line from the centre
    for (int k = 0; k < 3; ++k) {
        const double x = org[k] + middle * dir[k];
        nearest2 += x * x;
    }
    const double half2 = (radius * radius - nearest2) / length2;
    if (half2 >= 0) {
        const double half = std::sqrt(half2);
        if (middle - half >= near && middle - half <= far) return middle - half;
        if (middle + half >= near && middle + half <= far) return middle + half;
    } else if (middle >= near && middle <= far && nearest2 <= (radius + margin) * (radius + margin)) {
        return middle;
    }
    return std::numeric_limits<double>::quiet_NaN();
}

/// Returns true if the end of the segment org + t·dir, at t = 1, is outside of the sphere.
bool ends_outside(const double (&org)[3], const double (&dir)[3], double radius) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += (org[k] + dir[k]) * (org[k] + dir[k]);
    return square > radius * radius;
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
        float& far = RTCRayN_tfar(ray, n, i);
        const bool is_ignored = segments.margin > 0 && segments.ignored[segment] == arguments->geomID;
        if (is_ignored && ends_outside(org, dir, sphere.radius)) continue;
        const double t = first_intersection(org, dir, sphere.radius, segments.margin, double(RTCRayN_tnear(ray, n, i)),
                                            double(far));
        if (std::isnan(t)) continue;
        const float old_far = far;
        far = std::min(float(t), old_far);
        if (context.hit_filter) {
            // A query with a filter has one ray.
            RTCHit candidate{};
            candidate.geomID = arguments->geomID;
            candidate.primID = 0;
            candidate.instID[0] = RTC_INVALID_GEOMETRY_ID;
            int valid = -1;
            RTCFilterFunctionNArguments filtered{};
            filtered.valid = &valid;
            filtered.geometryUserPtr = arguments->geometryUserPtr;
            filtered.context = arguments->context;
            filtered.ray = ray;
            filtered.hit = reinterpret_cast<RTCHitN*>(&candidate);
            filtered.N = 1;
            context.hit_filter(&filtered);
            if (valid == 0) {
                far = old_far;
                continue;
            }
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
