#include "media/crossing.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// The least sine of the angle between a ray and a surface at which a crossing is certain.
constexpr double least_sine = 1e-5;

/// Bound on the rounding errors of the products of three lengths in add_triangle, relative to these lengths.
constexpr double product_rounding = 1e-14;

void add_point(double distance, bool against_normal, bool is_certain, Crossing& crossing) {
    if (!is_certain) crossing.uncertain_distance = std::min(crossing.uncertain_distance, distance);
    if (!is_certain || distance >= crossing.distance) return;
    crossing.distance = distance;
    crossing.against_normal = against_normal;
}

}  // namespace

void add_sphere(const StraightRay& ray, const Double3& center, double radius, bool starts_on_it, Crossing& crossing) {
    const Double3 offset = subtract(ray.origin, center);
    const double along = dot(offset, ray.direction);
    // The distance of the ray's line from the centre follows without cancellation from the perpendicular part.
    const double line_distance = length(subtract(offset, scaled(ray.direction, along)));
    const double cosine = line_distance / radius;
    const bool is_tangent = std::abs(cosine - 1) < 0.5 * least_sine * least_sine;
    if (cosine >= 1 && !is_tangent) return;
    const double half_chord = std::sqrt(std::max(0.0, (radius - line_distance) * (radius + line_distance)));
    const double entry = -along - half_chord, exit = -along + half_chord;
    // If the ray starts on the sphere, the root near 0 is its start.
    const bool starts_at_exit = starts_on_it && std::abs(exit) < std::abs(entry);
    if (entry > 0 && (!starts_on_it || starts_at_exit)) add_point(entry, true, !is_tangent, crossing);
    if (exit > 0 && !starts_at_exit) add_point(exit, false, !is_tangent, crossing);
}

// The signed volumes of the tetrahedra of the ray and the edges decide on which side of each edge the ray passes. An
// edge that two triangles share has the same volume for both, up to its sign.
void add_triangle(const StraightRay& ray, const Double3& a, const Double3& b, const Double3& c, Crossing& crossing) {
    const Double3 to_a = subtract(a, ray.origin), to_b = subtract(b, ray.origin), to_c = subtract(c, ray.origin);
    const double past_bc = dot(ray.direction, cross(to_b, to_c)), past_ca = dot(ray.direction, cross(to_c, to_a)),
                 past_ab = dot(ray.direction, cross(to_a, to_b));
    const double square = std::max({dot(to_a, to_a), dot(to_b, to_b), dot(to_c, to_c)});
    const double rounding = product_rounding * square;
    const double least = std::min({past_bc, past_ca, past_ab}), greatest = std::max({past_bc, past_ca, past_ab});
    if (least < -rounding && greatest > rounding) return;  // the ray passes the triangle on the outside
    const double sum = past_bc + past_ca + past_ab;        // d·n, times twice the area
    const Double3 normal = cross(subtract(b, a), subtract(c, a));
    const bool is_inside =
        least > rounding ||
        greatest<-rounding, is_transversal = std::abs(dot(ray.direction, normal))> least_sine * length(normal);
    if (is_inside && is_transversal) {
        const double distance = dot(to_a, normal) / dot(ray.direction, normal);
        if (distance > 0) add_point(distance, sum < 0, true, crossing);
        return;
    }
    // The ray meets an edge or lies nearly in the plane. The extent of the triangle along the ray bounds the distance
    // from below.
    const double first = std::min({dot(to_a, ray.direction), dot(to_b, ray.direction), dot(to_c, ray.direction)}),
                 last = std::max({dot(to_a, ray.direction), dot(to_b, ray.direction), dot(to_c, ray.direction)});
    if (last > 0) add_point(std::max(first, 0.0), false, false, crossing);
}

}  // namespace kagero
