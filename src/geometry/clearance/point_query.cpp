#include "geometry/clearance/point_query.h"

#include <cmath>
#include <limits>

namespace kagero {

float search_radius(const Geometry& geometry, double distance) {
    const auto radius = static_cast<float>(distance * geometry.scale);
    return std::nextafter(radius, std::numeric_limits<float>::infinity());
}

void query_around(const Geometry& geometry, RTCScene scene, const Double3& stretch, const Double3& q, double distance,
                  RTCPointQueryFunction visit, void* user) {
    const auto coordinate = [&](std::size_t k) {
        return static_cast<float>((q[k] - geometry.shift[k]) * geometry.scale * stretch[k]);
    };
    RTCPointQuery point{};
    point.x = coordinate(0);
    point.y = coordinate(1);
    point.z = coordinate(2);
    point.radius = search_radius(geometry, distance);
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene, &point, &context, visit, user);
}

}  // namespace kagero
