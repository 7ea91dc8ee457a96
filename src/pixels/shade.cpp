#include "pixels/shade.h"

#include "appearance/redshift.h"
#include "error.h"
#include "geometry/shapes.h"
#include "rays/camera.h"
#include "rays/pixel_rays.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kagero {
namespace {

double redshift_of(const Plan& plan, const PixelSample& ray) {
    return kagero::redshift_of(plan.scene->sources, plan.view.spacetime, ray);
}

/// Returns the colour of the light at the end of a ray. Captured rays are black, because no light arrives along them.
/// Failed and unfinished rays are black too; the layer `status` distinguishes them. The light of diffuse surfaces is
/// part of the path.
Float3 color_at_end(const Plan& plan, const PixelSample& ray) {
    const RayEnd& end = *ray.end;
    const Double3 toward{end.v[0], end.v[1], end.v[2]};
    switch (end.status) {
        case Status::hit: {
            const Double3 point{end.q[0], end.q[1], end.q[2]};
            const Paints& paints = *plan.scene->paints;
            if (plan.description().objects[end.surface].material == Material::diffuse) return {0, 0, 0};
            const bool is_black_body = paints.object(end.surface).temperature > 0;
            return paints.surface_color(end.surface, end.primitive, point, toward,
                                        is_black_body ? 1 : redshift_of(plan, ray), ray.patch,
                                        is_black_body ? &ray.source_color : nullptr);
        }
        case Status::escaped: return ray.source_color;
        default:
            return {0, 0, 0};
    }
}

/// Returns the colour of a ray.
Float3 color_of(const Plan& plan, const PixelSample& ray) {
    Float3 color = color_at_end(plan, ray);
    if (!ray.path) return color;
    const auto& [weight, light] = std::tie(ray.path->weight, ray.path->light);
    for (std::size_t k = 0; k < 3; ++k) color[k] = float(color[k] * weight[k] + light[k]);
    return color;
}

/// Returns the distance from the start of a ray to its hit, in scene units; 0 without a hit.
double depth_of(const Plan& plan, const PixelSample& ray) {
    if (ray.end->status != Status::hit) return 0;
    const Scene& around = *plan.medium(plan.view.medium).scene;
    const Double3 from = add(start_position(around.space, ray.ray->start),
                             subtract(around.description.space.center, plan.description().space.center));
    const double* to = ray.end->q;
    return plan.scene->unit * std::hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
}

/// Returns the mean of a quantity over the rays of a pixel. The terms are added in the order of the samples, so the
/// result is reproducible.
template <class Quantity>
float mean(std::span<const PixelSample> rays, const Quantity& quantity) {
    double sum = 0;
    for (const PixelSample& ray : rays) sum += quantity(*ray.end);
    return float(sum / double(rays.size()));
}

/// Writes the standard errors of the components of a pixel's colour, from the means of the independent groups of its
/// rays: se² = G/(G − 1) Σ_g (n_g/n)² (m_g − m)², with the mean m_g of the n_g rays of group g of G. NaN if there is
/// only one ray.
void write_standard_error(const Pixel& pixel, float* error) {
    const PixelRays divided(pixel.plan.description());
    const std::size_t n = pixel.rays.size(), groups = std::min<std::size_t>(divided.groups(), n);
    std::array<Double3, PixelRays::max_groups> sums{};
    std::array<double, PixelRays::max_groups> counts{};
    Double3 mean{};
    for (std::uint32_t i = 0; i < n; ++i) {
        const Float3 c = color_of(pixel.plan, pixel.rays[i]);
        const std::uint32_t group = divided.group_of(i);
        ++counts[group];
        for (std::size_t k = 0; k < 3; ++k) {
            sums[group][k] += double(c[k]);
            mean[k] += double(c[k]) / double(n);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        double square = 0;
        for (std::size_t g = 0; g < groups; ++g) {
            const double deviation = (sums[g][k] - counts[g] * mean[k]) / double(n);
            square += deviation * deviation;
        }
        error[k] = float(std::sqrt(square * double(groups) / (double(groups) - 1)));
    }
}

void write_color(const Pixel& pixel, float* color) {
    if (pixel.rays.size() == 1) {
        const Float3 c = color_of(pixel.plan, pixel.rays.front());
        std::copy(c.begin(), c.end(), color);
        return;
    }
    double sum[3] = {0, 0, 0};
    for (const PixelSample& ray : pixel.rays) {
        const Float3 c = color_of(pixel.plan, ray);
        for (std::size_t k = 0; k < 3; ++k) sum[k] += c[k];
    }
    for (int k = 0; k < 3; ++k) color[k] = float(sum[k] / double(pixel.rays.size()));
}

/// Returns the footprint of the whole pixel on the sky to which its first ray escapes; zero if that ray does not
/// escape.
Footprint sky_footprint(const Pixel& pixel) {
    const PixelSample& ray = pixel.rays.front();
    if (ray.end->status != Status::escaped) return {};
    const double enlargement = std::sqrt(double(pixel.rays.size()));  // the footprint is that of one ray
    return {scaled(ray.footprint.major, enlargement), scaled(ray.footprint.minor, enlargement)};
}

/// Returns the solid angle of a footprint, up to a constant factor.
double solid_angle_of(const Footprint& footprint) {
    return length(footprint.major) * length(footprint.minor);
}

/// Returns the footprint of a pixel in the observer's rest frame. It is fitted to the view directions of the same block
/// of 2 × 2 pixels as the footprint on the sky.
Footprint view_footprint(const Plan& plan, std::uint32_t x, std::uint32_t y) {
    std::vector<Double3> directions;
    std::vector<std::array<double, 2>> positions;
    for (const std::uint32_t i : {y & ~1u, y | 1u})
        for (const std::uint32_t k : {x & ~1u, x | 1u}) {
            positions.push_back({k + 0.5, i + 0.5});
            const Double3 d = camera_direction(plan, positions.back()[0], positions.back()[1]);
            directions.push_back(scaled(d, 1 / length(d)));
        }
    return fit_footprint(directions, positions);
}

/// Returns the solid angle of the pixel in the observer's rest frame, divided by its solid angle on the sky; 0 if
/// either is unknown.
double magnification_of(const Pixel& pixel) {
    const double sky = solid_angle_of(sky_footprint(pixel));
    return sky > 0 && pixel.plan.description().camera.type != CameraType::orthographic
               ? solid_angle_of(view_footprint(pixel.plan, pixel.x, pixel.y)) / sky
               : 0;
}

double energy_error_of(const Pixel& pixel) {
    double greatest = 0;
    for (const PixelSample& ray : pixel.rays) greatest = std::max(greatest, ray.end->energy_error);
    return greatest;
}

/// Returns the greatest error of the pixel's rays; NaN if the error of one of them is NaN.
double greatest_error(const Pixel& pixel, double EndError::*error) {
    double greatest = 0;
    for (const PixelSample& ray : pixel.rays)
        if (!std::isnan(greatest) && !(ray.error->*error <= greatest)) greatest = ray.error->*error;
    return greatest;
}

/// Returns the number of the object that the pixel's first ray hits, counted from 1; 0 without a hit.
double object_of(const Pixel& pixel) {
    const RayEnd& end = *pixel.rays.front().end;
    return end.status == Status::hit ? pixel.plan.description().objects[end.surface].scene_index + 1 : 0;
}

/// Returns the mean of a length over the rays of a pixel, in scene units.
template <class Length>
float scene_length(const Pixel& pixel, const Length& length_of) {
    return mean(pixel.rays, [&](const RayEnd& end) { return pixel.plan.scene->unit * length_of(end); });
}

/// The function that computes a layer. `layer` is a name in the table of src/film/film.cpp.
struct LayerWriter {
    const char* layer;
    unsigned needs;  ///< Bits of Need.
    void (*write)(const Pixel&, float*);
};
constexpr LayerWriter layer_writers[] = {
    {"color", 0, write_color},
    {"standard_error", 0, write_standard_error},
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
    {"action", need_action,
     [](const Pixel& p, float* out) { *out = scene_length(p, [](const RayEnd& end) { return end.action; }); }},
    {"time", need_time,
     [](const Pixel& p, float* out) { *out = scene_length(p, [](const RayEnd& end) { return end.time; }); }},
    {"traced", 0, [](const Pixel& p, float* out) { *out = p.rays.front().interpolated ? 0 : 1; }},
    {"footprint", need_footprint, [](const Pixel& p, float* out) { *out = float(length(sky_footprint(p).major)); }},
    {"magnification", need_footprint, [](const Pixel& p, float* out) { *out = float(magnification_of(p)); }},
};

const LayerWriter& writer_of(const std::string& layer) {
    const auto writer = std::find_if(std::begin(layer_writers), std::end(layer_writers),
                                     [&](const LayerWriter& candidate) { return candidate.layer == layer; });
    if (writer == std::end(layer_writers))
        throw RunError("the layer " + layer + " has no function in the table of src/pixels/shade.cpp; add one");
    return *writer;
}

}  // namespace

unsigned needs_of(const std::string& layer) { return writer_of(layer).needs; }

unsigned needs_of(const Film& film) {
    unsigned needs = 0;
    for (const LayerInfo* layer : film.layers()) needs |= needs_of(layer->name);
    return needs;
}

Shader::Shader(Film& film) : width_(film.width()) {
    for (const LayerInfo* layer : film.layers())
        layers_.push_back({writer_of(layer->name).write, film.plane(layer->name), layer->channels.size()});
}

void Shader::shade(const Pixel& pixel, std::uint32_t x, std::uint32_t y) const {
    for (const Layer& layer : layers_) layer.write(pixel, layer.plane + (y * width_ + x) * layer.channels);
}

}  // namespace kagero
