#include "accuracy/rounding_bounds.h"

#include "accuracy/ray_errors.h"
#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Rays whose paths are kept at a time: a few packets.
constexpr std::size_t paths_together = 64;

/// Half a unit in the last place of 1.
double half_place_of(const Plan& plan) {
    return plan.run.kernel->precision == Precision::float32 ? 0x1p-24 : 0x1p-53;
}

Double3 of(const double (&x)[3]) {
    return {x[0], x[1], x[2]};
}

void put(const Double3& from, double (&to)[3]) {
    std::copy(from.begin(), from.end(), to);
}

Double3 normal_at(const Surface& surface, std::uint32_t primitive, const Double3& q) {
    if (surface.kind == Surface::Kind::sphere) return subtract(q, of(surface.center));
    const auto vertex = [&](int k) {
        const double* v = surface.vertices + 3 * std::size_t{surface.triangles[3 * std::size_t{primitive} + k]};
        return Double3{v[0], v[1], v[2]};
    };
    return cross(subtract(vertex(1), vertex(0)), subtract(vertex(2), vertex(0)));
}

/// Of what a ray ends on: a surface, one of the escape spheres, or the edge of the medium, of which nothing more is
/// known.
Double3 normal_at(const Plan& plan, const RayEnd& end) {
    const Double3 q = of(end.q);
    if (end.status == Status::hit)
        return normal_at(plan.scene->geometry->kernel_view()->surfaces[end.surface], end.primitive, q);
    constexpr double near = 1e-3;
    const auto on_sphere = [&](double radius) { return std::abs(length(q) - radius) <= near * radius; };
    return on_sphere(plan.scene->limits.escape_radius) || on_sphere(plan.scene->limits.inner_escape_radius) ? q
                                                                                                            : of(end.v);
}

/// How what is seen moves with the end of a ray: along two axes across it, in pixels.
void look_at_end(const Plan& plan, const RayEnd& end, RayPath& path) {
    const Double3 normal = normal_at(plan, end), q = of(end.q);
    const double pixels = 1 / pixel_at(plan, end);
    put(normal, path.normal);
    if (!seen_by_direction(plan, end)) {
        const auto across = meridians(normal);
        for (std::size_t r = 0; r < 2; ++r) put(scaled(across[r], pixels), path.by_position[r]);
        return;
    }
    const SkyView view = sky_view(plan.scene->space, end);
    const auto across = meridians(view.direction);
    for (std::size_t r = 0; r < 2; ++r) {
        if (!view.far) {
            put(scaled(across[r], pixels), path.by_direction[r]);
            continue;
        }
        // Of d − 2 (d·n) n, n = q/|q|.
        const Double3 n = unit(q), d = of(end.v), &a = across[r];
        put(scaled(subtract(a, scaled(n, 2 * dot(a, n))), pixels), path.by_direction[r]);
        const Double3 turn = add(scaled(d, dot(a, n)), scaled(a, dot(d, n)));
        put(scaled(subtract(turn, scaled(n, dot(turn, n))), -2 * pixels / length(q)), path.by_position[r]);
    }
}

/// The paths of rays, by their number.
struct Paths {
    std::vector<std::vector<PathPoint>> points;
    std::vector<RayEnd> ends;

    Paths(const Plan& plan, const RayList& rays, const Halt& halt) : points(rays.starts.size()) {
        Job job = plan.job();
        halt.tell(job);
        job.refill = false;
        job.path_user = this;
        job.path_sink = [](void* user, const PathPoint* point) {
            static_cast<Paths*>(user)->points[static_cast<std::size_t>(point->ray)].push_back(*point);
        };
        Counters unused{};
        trace_tile(*plan.run.kernel, job, {}, rays, ends, unused);
    }
};

std::vector<RayStart> starts_of(const Plan& plan, const Tile& tile, const RayList& list) {
    if (!list.starts.empty()) return list.starts;
    std::vector<RayStart> starts;
    for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
        for (std::uint32_t x = tile.x0; x < tile.x1; ++x) starts.push_back(pixel_ray(plan, x, y));
    return starts;
}

/// The roundings of a ray's start, its direction and its end, as if it were straight; where a surface is not met at
/// right angles they move the end farther along that.
double bound_of_ends(const Plan& plan, const RayStart& start, const RayEnd& end) {
    constexpr double roundings_of_direction = 4, roundings_of_places = 2;
    const double half_place = half_place_of(plan), direction = roundings_of_direction * half_place;
    if (seen_by_direction(plan, end)) return direction / pixel_at(plan, end);
    const Double3 from = of(start.q), to = of(end.q), normal = normal_at(plan, end);
    const double slant = std::abs(dot(normal, of(end.v))) / (length(normal) * length(of(end.v)));
    const double off =
        direction * length(subtract(to, from)) + roundings_of_places * half_place * (length(from) + length(to));
    return off / (std::max(slant, half_place) * pixel_at(plan, end));
}

/// Of a few of the rays that `ends` and `bounds` are of, by their places there.
void bound_few(const Plan& plan, const RayList& rays, const std::vector<std::size_t>& places, const RayEnd* ends,
               double* bounds, const Halt& halt) {
    const Paths traced(plan, rays, halt);
    if (halt()) return;
    std::vector<RayPath> paths;
    std::vector<std::size_t> wanted;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const std::vector<PathPoint>& points = traced.points[i];
        if (points.empty() || !same_class(ends[places[i]], traced.ends[i])) continue;
        paths.push_back({points.data(), static_cast<std::uint32_t>(points.size()), {}, {}, {}});
        look_at_end(plan, traced.ends[i], paths.back());
        wanted.push_back(i);
    }
    std::vector<double> pixels(paths.size());
    const Job job = plan.job();
    plan.module().bound_roundings(&job, paths.data(), static_cast<std::uint32_t>(paths.size()), half_place_of(plan),
                                  pixels.data());
    for (std::size_t i = 0; i < wanted.size(); ++i)
        bounds[places[wanted[i]]] = pixels[i] + bound_of_ends(plan, rays.starts[wanted[i]], ends[places[wanted[i]]]);
}

}  // namespace

std::vector<double> rounding_bounds(const Plan& plan, const Tile& tile, const RayEnd* ends, const RayList& list,
                                    const Halt& halt) {
    const std::vector<RayStart> starts = starts_of(plan, tile, list);
    std::vector<double> bounds;
    RayList few;
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < starts.size(); ++i) {
        bounds.push_back(ends[i].status == Status::captured ? 0 : std::numeric_limits<double>::quiet_NaN());
        if (plan.scene->straight && has_end(ends[i])) bounds.back() = bound_of_ends(plan, starts[i], ends[i]);
        else if (has_end(ends[i])) few.starts.push_back(starts[i]), places.push_back(i);
        if (places.empty() || (places.size() < paths_together && i + 1 < starts.size())) continue;
        bound_few(plan, few, places, ends, bounds.data(), halt);
        if (halt()) return bounds;
        few.starts.clear(), places.clear();
    }
    return bounds;
}

}  // namespace kagero
