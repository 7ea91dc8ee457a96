#include "accuracy/rounding_bounds.h"

#include "accuracy/ray_errors.h"
#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Number of rays whose paths are stored at the same time.
constexpr std::size_t paths_per_batch = 64;

/// Returns half a unit in the last place of 1 in the plan's precision.
double unit_roundoff_of(const Plan& plan) {
    return plan.run.kernel->precision == Precision::float32 ? 0x1p-24 : 0x1p-53;
}

Double3 to_double3(const double (&x)[3]) { return {x[0], x[1], x[2]}; }

void copy(const Double3& from, double (&to)[3]) { std::copy(from.begin(), from.end(), to); }

/// Returns a normal of an object at q, of any length. `primitive` is the index of a triangle; spheres ignore it.
Double3 normal_at(const ObjectGeometry& object, std::uint32_t primitive, const Double3& q) {
    if (object.shape == Shape::sphere) return subtract(q, object.center);
    const auto corner = [&](std::size_t k) {
        return vertex(object.mesh, object.mesh.triangles[3 * std::size_t{primitive} + k]);
    };
    return cross(subtract(corner(1), corner(0)), subtract(corner(2), corner(0)));
}

/// Returns the normal of the surface or escape sphere on which a ray ends. For the edge of a medium, whose normal is
/// not available, returns the direction of the ray.
Double3 normal_at(const Plan& plan, const RayEnd& end) {
    const Double3 q = to_double3(end.q);
    if (end.status == Status::hit)
        return normal_at(plan.scene->geometry->objects()[end.surface], end.primitive, q);
    constexpr double tolerance = 1e-3;
    const auto on_sphere = [&](double radius) { return std::abs(length(q) - radius) <= tolerance * radius; };
    return on_sphere(plan.scene->limits.escape_radius) || on_sphere(plan.scene->limits.inner_escape_radius)
               ? q
               : to_double3(end.v);
}

/// Sets the normal of the path, and the derivatives of the two pixel coordinates with respect to the ray's end point
/// and direction, in pixels. The coordinates are measured along two axes perpendicular to the normal, or to the
/// direction on the sky. Distant observers with a velocity see directions with aberration.
void set_pixel_derivatives(const Plan& plan, const RayEnd& end, RayPath& path) {
    const Double3 normal = normal_at(plan, end), q = to_double3(end.q);
    const double pixels_per_unit = 1 / pixel_size_at(plan, end);
    copy(normal, path.normal);
    if (!is_seen_by_direction(plan, end)) {
        const auto axes = axes_around(normal);
        for (std::size_t r = 0; r < 2; ++r) copy(scaled(axes[r], pixels_per_unit), path.by_position[r]);
        return;
    }
    const SkyView view = sky_view(plan.scene->sources.skies, end);
    const auto axes = axes_around(view.direction);
    if (const auto derivatives = sky_derivatives(plan.scene->sources.skies, end)) {
        for (std::size_t r = 0; r < 2; ++r)
            for (std::size_t k = 0; k < 3; ++k) {
                path.by_position[r][k] = pixels_per_unit * dot(axes[r], derivatives->by_position[k]);
                path.by_direction[r][k] = pixels_per_unit * dot(axes[r], derivatives->by_direction[k]);
            }
        return;
    }
    for (std::size_t r = 0; r < 2; ++r) {
        if (!view.reflected) {
            copy(scaled(axes[r], pixels_per_unit), path.by_direction[r]);
            continue;
        }
        // Derivatives of the direction on the second sheet: the reflected direction d − 2 (d·n) n with n = q/|q|. The
        // derivative with respect to n is projected perpendicular to n, because |n| = 1.
        const Double3 n = unit(q), d = to_double3(end.v), &a = axes[r];
        copy(scaled(subtract(a, scaled(n, 2 * dot(a, n))), pixels_per_unit), path.by_direction[r]);
        const Double3 by_normal = add(scaled(d, dot(a, n)), scaled(a, dot(d, n)));
        copy(scaled(subtract(by_normal, scaled(n, dot(by_normal, n))), -2 * pixels_per_unit / length(q)),
             path.by_position[r]);
    }
}

/// Paths and ends of the rays of a list, in the order of the list. The constructor traces the rays.
struct Paths {
    std::vector<std::vector<PathPoint>> points;
    std::vector<RayEnd> ends;

    Paths(const Plan& plan, const RayList& rays, const CancelToken& cancel) : points(rays.starts.size()) {
        Job job = plan.job();
        cancel.install(job);
        job.refill = false;
        job.path_user = this;
        job.path_sink = [](void* user, const PathPoint* point) {
            static_cast<Paths*>(user)->points[static_cast<std::size_t>(point->ray)].push_back(*point);
        };
        Counters unused{};
        trace_tile(*plan.run.kernel, job, {}, rays, ends, unused);
    }
};

/// Returns the ray starts of a tile: those of the list, or of the camera's pixels if the list is empty.
std::vector<RayStart> starts_of(const Plan& plan, const Tile& tile, const RayList& list) {
    if (!list.starts.empty()) return list.starts;
    std::vector<RayStart> starts;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    return starts;
}

/// Returns the greatest factor by which the aberration for the distant observers magnifies a change of a ray's
/// direction; 1 without such observers.
double magnification_of_sky(const Plan& plan, const RayEnd& end) {
    const auto derivatives = sky_derivatives(plan.scene->sources.skies, end);
    if (!derivatives) return 1;
    double square = 0;  // sum of the squares of the singular values, of which one is 0
    for (const Double3& column : derivatives->by_direction) square += dot(column, column);
    return std::sqrt(square);
}

/// Returns a bound on the effect of rounding the ray's start, direction and end, in pixels. The ray is treated as
/// straight. At oblique incidence on a surface, the end point moves farther: by the factor 1/cos(angle of incidence).
double start_and_end_bound(const Plan& plan, const RayStart& start, const RayEnd& end) {
    constexpr double roundings_of_direction = 4, roundings_of_positions = 2;  // numbers of roundings
    const double unit_roundoff = unit_roundoff_of(plan), direction_error = roundings_of_direction * unit_roundoff;
    if (is_seen_by_direction(plan, end))
        return direction_error * magnification_of_sky(plan, end) / pixel_size_at(plan, end);
    const Double3 start_point = to_double3(start.q), end_point = to_double3(end.q), normal = normal_at(plan, end);
    const double cosine = std::abs(dot(normal, to_double3(end.v))) / (length(normal) * length(to_double3(end.v)));
    const double displacement = direction_error * length(subtract(end_point, start_point)) +
                                roundings_of_positions * unit_roundoff * (length(start_point) + length(end_point));
    return displacement / (std::max(cosine, unit_roundoff) * pixel_size_at(plan, end));
}

/// Computes the bounds of a batch of rays. `indices` contains the index of each ray of the batch in `ends` and
/// `bounds`.
void bound_batch(const Plan& plan, const RayList& rays, const std::vector<std::size_t>& indices, const RayEnd* ends,
                 double* bounds, const CancelToken& cancel) {
    const Paths traced(plan, rays, cancel);
    if (cancel()) return;
    std::vector<RayPath> paths;
    std::vector<std::size_t> ray_of_path;  // index in the batch
    for (std::size_t i = 0; i < indices.size(); ++i) {
        const std::vector<PathPoint>& points = traced.points[i];
        if (points.empty() || !same_status_and_object(ends[indices[i]], traced.ends[i])) continue;
        paths.push_back({points.data(), static_cast<std::uint32_t>(points.size()), {}, {}, {}});
        set_pixel_derivatives(plan, traced.ends[i], paths.back());
        ray_of_path.push_back(i);
    }
    std::vector<double> path_bounds(paths.size());
    const Job job = plan.job();
    plan.module().bound_roundings(&job, paths.data(), static_cast<std::uint32_t>(paths.size()), unit_roundoff_of(plan),
                                  path_bounds.data());
    for (std::size_t i = 0; i < ray_of_path.size(); ++i) {
        const std::size_t ray = ray_of_path[i], index = indices[ray];
        bounds[index] = path_bounds[i] + start_and_end_bound(plan, rays.starts[ray], ends[index]);
    }
}

}  // namespace

std::vector<double> rounding_bounds(const Plan& plan, const Tile& tile, const RayEnd* ends, const RayList& list,
                                    const CancelToken& cancel) {
    const std::vector<RayStart> starts = starts_of(plan, tile, list);
    std::vector<double> bounds;
    RayList batch;
    std::vector<std::size_t> indices;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        bounds.push_back(ends[i].status == Status::captured ? 0 : std::numeric_limits<double>::quiet_NaN());
        if (plan.scene->straight && has_visible_end(ends[i]))
            bounds.back() = start_and_end_bound(plan, starts[i], ends[i]);
        else if (has_visible_end(ends[i])) {
            batch.starts.push_back(starts[i]);
            indices.push_back(i);
        }
        if (indices.empty() || (indices.size() < paths_per_batch && i + 1 < starts.size())) continue;
        bound_batch(plan, batch, indices, ends, bounds.data(), cancel);
        if (cancel()) return bounds;
        batch.starts.clear();
        indices.clear();
    }
    return bounds;
}

}  // namespace kagero
