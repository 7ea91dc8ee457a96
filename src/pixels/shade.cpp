#include "pixels/shade.h"

#include "appearance/redshift.h"
#include "error.h"
#include "geometry/shapes.h"
#include "rays/camera.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// A ray that gets away alone, beside captured ones or those that end under the other sky, has grazed the photon
/// sphere: around there every pixel shows the whole sky, again and again. It stands for a large piece of it.
Footprint filter_of(const SkyView& view, const SkyFootprints& footprints) {
    constexpr double large = 0.5;  // radian
    const Footprint& known = view.far ? footprints.far : footprints.near;
    if (!footprints.torn || length(known.major) > 0) return known;
    const auto [e1, e2] = meridians(view.direction);
    return {scaled(e1, large), scaled(e2, large)};
}

double redshift_of(const Plan& plan, const PixelSample& ray) {
    return kagero::redshift_of(plan.scene->space, plan.view.spacetime, plan.description().objects, ray);
}

/// Captured rays come from nowhere and are black; so are rays without an end, which the status layer tells apart.
Float3 color_of(const Plan& plan, const PixelSample& ray, const SkyFootprints& footprints) {
    const RayEnd& end = *ray.end;
    const Double3 toward{end.v[0], end.v[1], end.v[2]};
    switch (end.status) {
        case Status::hit:
            return plan.scene->paints->surface_color(end.surface, end.primitive, {end.q[0], end.q[1], end.q[2]}, toward,
                                                redshift_of(plan, ray), ray.patch);
        case Status::escaped:
            return plan.scene->paints->sky_color(ray.sky.direction, ray.sky.far, filter_of(ray.sky, footprints));
        default:
            return {0, 0, 0};
    }
}

/// Distance in scene units from the ray's start to the hit; 0 without one.
double depth_of(const Plan& plan, const PixelSample& ray) {
    if (ray.end->status != Status::hit) return 0;
    const double *from = ray.ray->start.q, *to = ray.end->q;
    return plan.scene->unit * std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

/// Added up in the order of the samples, so that the sum is always the same.
template <class Amount>
float mean(std::span<const PixelSample> rays, const Amount& amount) {
    double sum = 0;
    for (const PixelSample& ray : rays) sum += amount(*ray.end);
    return float(sum / double(rays.size()));
}

void paint_color_of(const Pixel& pixel, float* color) {
    if (pixel.rays.size() == 1) {
        const Float3 c = color_of(pixel.plan, pixel.rays.front(), pixel.footprints);
        std::copy(c.begin(), c.end(), color);
        return;
    }
    double sum[3] = {0, 0, 0};
    for (const PixelSample& ray : pixel.rays) {
        const Float3 c = color_of(pixel.plan, ray, pixel.footprints);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
    }
    for (int k = 0; k < 3; ++k) color[k] = float(sum[k] / double(pixel.rays.size()));
}

/// The piece of sky that the pixel shows by its first ray; axes of length zero where that is not known.
Footprint sky_of(const Pixel& pixel) {
    const PixelSample& ray = pixel.rays.front();
    if (ray.end->status != Status::escaped) return {};
    const Footprint& f = ray.sky.far ? pixel.footprints.far : pixel.footprints.near;
    const double pixel_per_ray = std::sqrt(double(pixel.rays.size()));
    return {scaled(f.major, pixel_per_ray), scaled(f.minor, pixel_per_ray)};
}

double solid_angle_of(const Footprint& sky) {
    return length(sky.major) * length(sky.minor);
}

/// What the observer sees through the block of 2 × 2 pixels that a footprint is of: its directions as they spread at
/// the camera.
Footprint view_of(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    std::vector<Double3> directions;
    std::vector<std::array<double, 2>> places;
    for (const std::uint32_t i : {y & ~1u, y | 1u})
        for (const std::uint32_t k : {x & ~1u, x | 1u}) {
            places.push_back({k + 0.5, i + 0.5});
            const Double3 d = camera_direction(plan, places.back()[0], places.back()[1]);
            directions.push_back(scaled(d, 1 / length(d)));
        }
    return spread_of(directions, places);
}

double magnification_of(const Pixel& pixel) {
    const double sky = solid_angle_of(sky_of(pixel));
    return sky > 0 && pixel.plan.description().camera.type != CameraType::orthographic
               ? solid_angle_of(view_of(pixel.plan, pixel.x, pixel.y)) / sky
               : 0;
}

double energy_error_of(const Pixel& pixel) {
    double greatest = 0;
    for (const PixelSample& ray : pixel.rays) greatest = std::max(greatest, ray.end->energy_error);
    return greatest;
}

/// The greatest of the pixel's rays; not a number where that is so of one of them.
double greatest_error(const Pixel& pixel, double EndError::*error) {
    double greatest = 0;
    for (const PixelSample& ray : pixel.rays)
        if (!std::isnan(greatest) && !(ray.error->*error <= greatest)) greatest = ray.error->*error;
    return greatest;
}

double object_of(const Pixel& pixel) {
    const RayEnd& end = *pixel.rays.front().end;
    return end.status == Status::hit ? end.surface + 1 : 0;
}

/// How each layer of film.cpp is made, and from what.
struct Painter {
    const char* layer;
    unsigned needs;
    void (*paint)(const Pixel&, float*);
};
constexpr Painter painters[] = {
    {"color", 0, paint_color_of},
    {"status", 0, [](const Pixel& p, float* out) { *out = float(static_cast<int>(p.rays.front().end->status)); }},
    {"steps", 0, [](const Pixel& p, float* out) { *out = mean(p.rays, [](const RayEnd& end) { return end.steps; }); }},
    {"gradients", 0,
     [](const Pixel& p, float* out) { *out = mean(p.rays, [](const RayEnd& end) { return end.gradients; }); }},
    {"energy_error", need_energy_error, [](const Pixel& p, float* out) { *out = float(energy_error_of(p)); }},
    {"position_error", need_position_error,
     [](const Pixel& p, float* out) { *out = float(greatest_error(p, &EndError::position)); }},
    {"rounding_error", need_rounding_error,
     [](const Pixel& p, float* out) { *out = float(greatest_error(p, &EndError::rounding)); }},
    {"newton", 0,
     [](const Pixel& p, float* out) { *out = mean(p.rays, [](const RayEnd& end) { return end.iterations; }); }},
    {"occupancy", 0, [](const Pixel& p, float* out) { *out = p.rays.front().end->occupancy; }},
    {"depth", need_start, [](const Pixel& p, float* out) { *out = float(depth_of(p.plan, p.rays.front())); }},
    {"redshift", need_start, [](const Pixel& p, float* out) { *out = float(redshift_of(p.plan, p.rays.front())); }},
    {"object", 0, [](const Pixel& p, float* out) { *out = float(object_of(p)); }},
    {"footprint", need_footprint, [](const Pixel& p, float* out) { *out = float(length(sky_of(p).major)); }},
    {"magnification", need_footprint, [](const Pixel& p, float* out) { *out = float(magnification_of(p)); }},
};

const Painter& painter_of(const std::string& layer) {
    const auto painter =
        std::find_if(std::begin(painters), std::end(painters), [&](const Painter& p) { return p.layer == layer; });
    if (painter == std::end(painters)) throw RunError("nothing paints the layer " + layer);
    return *painter;
}

}  // namespace

unsigned needs_of(const std::string& layer) {
    return painter_of(layer).needs;
}

unsigned needs_of(const Film& film) {
    unsigned needs = 0;
    for (const LayerInfo* layer : film.layers()) needs |= needs_of(layer->name);
    return needs;
}

int probes_of(const Plan& plan, const PixelSample& ray, const SkyFootprints& footprints) {
    return ray.end->status == Status::escaped
               ? plan.scene->paints->sky_probes(ray.sky.far, filter_of(ray.sky, footprints))
               : 0;
}

Shader::Shader(Film& film) : width_(film.width()) {
    for (const LayerInfo* layer : film.layers())
        layers_.push_back({painter_of(layer->name).paint, film.plane(layer->name), layer->channels.size()});
}

void Shader::shade(const Pixel& pixel, std::uint32_t x, std::uint32_t y) const {
    for (const Layer& layer : layers_) layer.paint(pixel, layer.plane + (y * width_ + x) * layer.channels);
}

}  // namespace kagero
