#include "render/shade.h"

#include <cmath>

namespace kagero {
namespace {

Double3 scene_point(const Plan& plan, const RayEnd& end) {
    const Double3& c = plan.scene.space.center;
    return {end.q[0] + c[0], end.q[1] + c[1], end.q[2] + c[2]};
}

/// Captured rays come from nowhere and are black; so are rays without an end, which the status layer tells apart.
Float3 color_of(const Plan& plan, const RayEnd& end) {
    const Double3 toward{end.v[0], end.v[1], end.v[2]};
    switch (end.status) {
        case Status::hit: return plan.geometry->surface_color(end.surface, end.primitive, scene_point(plan, end), toward);
        case Status::escaped: return plan.geometry->sky_color(toward);
        default: return {0, 0, 0};
    }
}

/// Distance in coordinates from the camera to the hit; 0 without one.
double depth_of(const Plan& plan, const RayEnd& end) {
    if (end.status != Status::hit) return 0;
    const double* eye = plan.camera.position;
    return plan.unit * std::hypot(end.q[0] - eye[0], end.q[1] - eye[1], end.q[2] - eye[2]);
}

/// The value of a layer of one channel.
float value_of(const Plan& plan, const RayEnd& end, const std::string& layer) {
    if (layer == "status") return float(static_cast<int>(end.status));
    if (layer == "steps") return float(end.steps);
    if (layer == "gradients") return float(end.gradients);
    if (layer == "energy_error") return float(end.energy_error);
    if (layer == "depth") return float(depth_of(plan, end));
    return end.status == Status::hit ? float(plan.geometry->object_of(end.surface) + 1) : 0.0f;
}

}  // namespace

void shade(const Plan& plan, const RayEnd& end, Film& film, std::uint32_t x, std::uint32_t y) {
    for (const LayerInfo* layer : film.layers()) {
        float* pixel = film.pixel(layer->name, x, y);
        if (layer->name == "color") {
            const Float3 c = color_of(plan, end);
            for (int k = 0; k < 3; ++k) pixel[k] = c[k];
        } else {
            pixel[0] = value_of(plan, end, layer->name);
        }
    }
}

}  // namespace kagero
