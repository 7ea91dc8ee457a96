#include "render/footprint.h"

#include "render/far_sky.h"
#include "scene/shapes.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

/// Variances and covariance of pairs of numbers.
struct Covariance {
    double xx = 0, xy = 0, yy = 0;

    explicit Covariance(const std::vector<std::array<double, 2>>& points) {
        const double n = static_cast<double>(points.size());
        double x0 = 0, y0 = 0;
        for (const auto& [x, y] : points) x0 += x / n, y0 += y / n;
        for (const auto& [x, y] : points)
            xx += (x - x0) * (x - x0) / n, xy += (x - x0) * (y - y0) / n, yy += (y - y0) * (y - y0) / n;
    }
};

}  // namespace

Footprint spread_of(const std::vector<Double3>& directions, const std::vector<std::array<double, 2>>& places) {
    if (directions.size() < 2) return {};
    Double3 middle{};
    for (const Double3& d : directions) middle = add(middle, d);
    if (length(middle) == 0) middle = directions.front();
    const auto [e1, e2] = meridians(middle);
    std::vector<std::array<double, 2>> seen;
    for (const Double3& d : directions) seen.push_back({dot(d, e1), dot(d, e2)});
    const Covariance c(seen), p(places);
    const double spread = 0.5 * (p.xx + p.yy);
    if (!(spread > 0)) return {};
    // The principal axes: eigenvectors of the covariance.
    const double mean = 0.5 * (c.xx + c.yy), difference = std::hypot(0.5 * (c.xx - c.yy), c.xy);
    const double angle = 0.5 * std::atan2(2 * c.xy, c.xx - c.yy);
    const double major = std::sqrt((mean + difference) / spread), minor = std::sqrt(std::max(0.0, mean - difference) / spread);
    const Double3 along = add(scaled(e1, std::cos(angle)), scaled(e2, std::sin(angle)));
    const Double3 across = add(scaled(e1, -std::sin(angle)), scaled(e2, std::cos(angle)));
    return {scaled(along, major), scaled(across, minor)};
}

SkyFootprints footprints_of(const Plan& plan, const Quad& quad, std::uint32_t spp) {
    std::vector<Double3> directions[2];
    std::vector<std::array<double, 2>> places[2];
    for (std::size_t i = 0; i < quad.rays.size(); ++i) {
        if (quad.rays[i].end->status != Status::escaped) continue;
        const SkyView view = sky_view(plan, *quad.rays[i].end);
        directions[view.far].push_back(view.direction);
        places[view.far].push_back(quad.places[i]);
    }
    const double share = 1 / std::sqrt(static_cast<double>(spp));
    SkyFootprints footprints;
    for (const bool far : {false, true}) {
        Footprint& f = far ? footprints.far : footprints.near;
        f = spread_of(directions[far], places[far]);
        f = {scaled(f.major, share), scaled(f.minor, share)};
    }
    return footprints;
}

}  // namespace kagero
