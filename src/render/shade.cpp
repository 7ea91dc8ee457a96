#include "render/shade.h"

#include "render/far_sky.h"
#include "render/redshift.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

Double3 scene_point(const Plan& plan, const RayEnd& end) {
    const Double3& c = plan.scene.space.center;
    return {end.q[0] + c[0], end.q[1] + c[1], end.q[2] + c[2]};
}

/// Captured rays come from nowhere and are black; so are rays without an end, which the status layer tells apart.
Float3 color_of(const Plan& plan, const Sighting& ray, const SkyFootprints& footprints) {
    const RayEnd& end = *ray.end;
    const Double3 toward{end.v[0], end.v[1], end.v[2]};
    switch (end.status) {
        case Status::hit:
            return plan.geometry->surface_color(end.surface, end.primitive, scene_point(plan, end), toward,
                                                redshift_of(plan, ray));
        case Status::escaped: {
            const SkyView view = sky_view(plan, end);
            return plan.geometry->sky_color(view.direction, view.far, view.far ? footprints.far : footprints.near);
        }
        default:
            return {0, 0, 0};
    }
}

/// Distance in coordinates from the ray's start to the hit; 0 without one.
double depth_of(const Sighting& ray) {
    if (ray.end->status != Status::hit) return 0;
    const double *from = ray.ray.start.q, *to = ray.end->q;
    return std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

/// Added up in the order of the samples, so that the sum is always the same.
template <class Amount>
float mean(std::span<const Sighting> rays, const Amount& amount) {
    double sum = 0;
    for (const Sighting& ray : rays) sum += amount(*ray.end);
    return float(sum / double(rays.size()));
}

void write_color(const Plan& plan, std::span<const Sighting> rays, const SkyFootprints& footprints, float* pixel) {
    double sum[3] = {0, 0, 0};
    for (const Sighting& ray : rays) {
        const Float3 c = color_of(plan, ray, footprints);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
    }
    for (int k = 0; k < 3; ++k) pixel[k] = float(sum[k] / double(rays.size()));
}

/// The value of a layer of one channel.
float value_of(const Plan& plan, std::span<const Sighting> rays, const std::string& layer) {
    const RayEnd& first = *rays.front().end;
    if (layer == "status") return float(static_cast<int>(first.status));
    if (layer == "steps") return mean(rays, [](const RayEnd& end) { return end.steps; });
    if (layer == "gradients") return mean(rays, [](const RayEnd& end) { return end.gradients; });
    if (layer == "energy_error") {
        double greatest = first.energy_error;
        for (const Sighting& ray : rays) greatest = std::max(greatest, ray.end->energy_error);
        return float(greatest);
    }
    if (layer == "redshift") return float(redshift_of(plan, rays.front()));
    if (layer == "depth") return float(depth_of(rays.front()));
    return first.status == Status::hit ? float(plan.geometry->object_of(first.surface) + 1) : 0.0f;
}

}  // namespace

void shade(const Plan& plan, std::span<const Sighting> rays, const SkyFootprints& footprints, Film& film, std::uint32_t x,
           std::uint32_t y) {
    for (const LayerInfo* layer : film.layers()) {
        float* pixel = film.pixel(layer->name, x, y);
        if (layer->name == "color")
            write_color(plan, rays, footprints, pixel);
        else
            pixel[0] = value_of(plan, rays, layer->name);
    }
}

}  // namespace kagero
