#include "appearance/footprint.h"

#include "appearance/texture.h"
#include "geometry/shapes.h"
#include "scene/vector3.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns the covariance matrix of pairs (x, y).
Covariance covariance_of(const std::vector<std::array<double, 2>>& points) {
    const double n = static_cast<double>(points.size());
    double x0 = 0, y0 = 0;
    for (const auto& [x, y] : points) {
        x0 += x / n;
        y0 += y / n;
    }
    Covariance c;
    for (const auto& [x, y] : points) {
        c.xx += (x - x0) * (x - x0) / n;
        c.xy += (x - x0) * (y - y0) / n;
        c.yy += (y - y0) * (y - y0) / n;
    }
    return c;
}

/// Covariance matrix of a function of the film position whose values are pairs of numbers. The matrix is scaled to film
/// positions with a standard deviation of one pixel along both axes.
struct SpreadPerPixel {
    double xx = 0, xy = 0, yy = 0;
    bool along_a_line = false;  ///< True if the film positions lie on a line: the spread across the line is unknown.

    SpreadPerPixel(const std::vector<std::array<double, 2>>& pairs,
                   const std::vector<std::array<double, 2>>& positions) {
        const Covariance p = covariance_of(positions), c = covariance_of(pairs);
        const double spread = 0.5 * (p.xx + p.yy), determinant = p.xx * p.yy - p.xy * p.xy;
        if (!(spread > 0)) return;
        // If the covariance matrix of the positions is isotropic, like that of the pixel centres of a block, the matrix
        // of the pairs is divided by the variance of the positions.
        if (std::abs(p.xx - p.yy) + std::abs(p.xy) < 1e-9 * spread) {
            xx = c.xx / spread;
            xy = c.xy / spread;
            yy = c.yy / spread;
            return;
        }
        // Otherwise, the matrix is that of the least-squares linear map from positions to pairs, plus the covariance of
        // the residuals divided by the variance of the positions. At a focus the linear map vanishes.
        along_a_line = determinant <= 1e-6 * spread * spread;
        std::vector<Double3> points;
        for (const auto& [x, y] : pairs) points.push_back({x, y, 0});
        const Patch m = fit_patch(points, positions);
        // Element (i, k) of the covariance matrix of the mapped positions.
        const auto mapped = [&](std::size_t i, std::size_t k) {
            return p.xx * m.right[i] * m.right[k] + p.xy * (m.right[i] * m.below[k] + m.below[i] * m.right[k]) +
                   p.yy * m.below[i] * m.below[k];
        };
        const auto per_pixel = [&](std::size_t i, std::size_t k, double total) {
            return m.right[i] * m.right[k] + m.below[i] * m.below[k] + (total - mapped(i, k)) / spread;
        };
        xx = per_pixel(0, 0, c.xx);
        xy = per_pixel(0, 1, c.xy);
        yy = per_pixel(1, 1, c.yy);
    }
};

Double3 point_of(const RayEnd& end) {
    return {end.q[0], end.q[1], end.q[2]};
}
Double3 point_of(const PixelSample& ray) {
    return point_of(*ray.end);
}

/// Returns true if two rays of the same group hit the same face of the same object. The first ray is a hit.
bool hit_same_face(const SceneGeometry& geometry, const PixelSample& first, const PixelSample& second) {
    const RayEnd &a = *first.end, &b = *second.end;
    if (b.status != Status::hit || a.surface != b.surface || first.group != second.group || is_scattered(second))
        return false;
    return geometry.on_same_face(a.surface, a.primitive, point_of(a), b.primitive, point_of(b));
}

/// Returns the footprint whose axes are given along the unit vectors e1 and e2.
Footprint footprint_along(const PrincipalAxes& axes, const Double3& e1, const Double3& e2) {
    const auto vector_of = [&](const std::array<double, 2>& axis) {
        return add(scaled(e1, axis[0]), scaled(e2, axis[1]));
    };
    return {vector_of(axes.major), vector_of(axes.minor)};
}

/// Returns the footprint of a block with have_common_sky. It equals that of fit_footprint, but needs fewer operations
/// and no film positions. The four directions are an affine function of the film position, plus a bilinear term, which
/// is orthogonal to it.
Footprint common_footprint(const PixelBlock& block) {
    const auto direction = [&](std::size_t ray) { return block.rays[ray].sky.direction; };
    const Double3 upper = add(direction(0), direction(1)), lower = add(direction(2), direction(3));
    const auto [e1, e2] = axes_around(add(upper, lower));
    const Double3 falling = subtract(direction(3), direction(0)), rising = subtract(direction(1), direction(2));
    const Double3 right = add(falling, rising), below = subtract(falling, rising),
                  bilinear = subtract(add(direction(0), direction(3)), add(direction(1), direction(2)));
    Covariance sum;
    for (const Double3& term : {right, below, bilinear}) {
        const double x = 0.5 * dot(term, e1), y = 0.5 * dot(term, e2);
        sum.xx += x * x;
        sum.xy += x * y;
        sum.yy += y * y;
    }
    return footprint_along(principal_axes(sum), e1, e2);
}

}  // namespace

Footprint fit_footprint(const std::vector<Double3>& directions, const std::vector<std::array<double, 2>>& positions) {
    if (directions.size() < 2) return {};
    Double3 middle{};
    for (const Double3& d : directions) middle = add(middle, d);
    if (length(middle) == 0) middle = directions.front();
    const auto [e1, e2] = axes_around(middle);
    std::vector<std::array<double, 2>> projected;
    for (const Double3& d : directions) projected.push_back({dot(d, e1), dot(d, e2)});
    const SpreadPerPixel c(projected, positions);
    Footprint footprint = footprint_along(principal_axes(Covariance{c.xx, c.xy, c.yy}), e1, e2);
    // The spread across a line of film positions is unknown; it is set to the spread along the line.
    if (c.along_a_line) footprint.minor = cross(unit(middle), footprint.major);
    return footprint;
}

std::uint32_t group_by_path(PixelBlock& block) {
    std::vector<PixelSample>& rays = block.rays;
    if (rays.empty() || !rays[0].path) return 1;
    std::uint32_t groups = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (is_scattered(rays[i])) {
            rays[i].group = scattered_group;
            continue;
        }
        const auto same = std::find_if(rays.begin(), rays.begin() + std::ptrdiff_t(i), [&](const PixelSample& earlier) {
            return !is_scattered(earlier) && earlier.path->surfaces == rays[i].path->surfaces;
        });
        rays[i].group = same == rays.begin() + std::ptrdiff_t(i) ? groups++ : same->group;
    }
    return groups;
}

bool have_common_sky(const PixelBlock& block, std::uint32_t spp) {
    if (block.rays.size() != 4 || spp != 1) return false;
    return std::all_of(block.rays.begin(), block.rays.end(), [&](const PixelSample& ray) {
        return ray.group == block.rays[0].group && !is_scattered(ray) && ray.end->status == Status::escaped &&
               ray.sky.on_second_sheet == block.rays[0].sky.on_second_sheet;
    });
}

SkyFootprints footprints_of(PixelBlock& block, std::uint32_t spp, std::uint32_t group) {
    // Edge of the part of a pixel that one ray covers, in pixels.
    const double ray_size = 1 / std::sqrt(static_cast<double>(spp));
    SkyFootprints footprints;
    bool captured = false, reached[2] = {false, false};  // index of `reached`: on_second_sheet
    for (const PixelSample& ray : block.rays) {
        if (ray.group != group) continue;
        captured = captured || ray.end->status == Status::captured;
        if (ray.end->status == Status::escaped) reached[ray.sky.on_second_sheet] = true;
    }
    footprints.discontinuous = captured || (reached[false] && reached[true]);
    if (have_common_sky(block, spp)) {
        (reached[true] ? footprints.second_sheet : footprints.first_sheet) = common_footprint(block);
        return footprints;
    }
    for (const bool on_second_sheet : {false, true}) {
        block.group_points.clear();
        block.group_positions.clear();
        for (std::size_t i = 0; i < block.rays.size(); ++i) {
            const PixelSample& ray = block.rays[i];
            if (ray.end->status != Status::escaped || ray.sky.on_second_sheet != on_second_sheet || ray.group != group)
                continue;
            block.group_points.push_back(block.rays[i].sky.direction);
            block.group_positions.push_back(block.film_positions[i]);
        }
        Footprint& f = on_second_sheet ? footprints.second_sheet : footprints.first_sheet;
        f = fit_footprint(block.group_points, block.group_positions);
        f = {scaled(f.major, ray_size), scaled(f.minor, ray_size)};
    }
    return footprints;
}

Patch fit_patch(const std::vector<Double3>& points, const std::vector<std::array<double, 2>>& positions) {
    const Covariance p = covariance_of(positions);
    const double trace = p.xx + p.yy, determinant = p.xx * p.yy - p.xy * p.xy,
                 n = static_cast<double>(positions.size());
    if (!(trace > 0)) return {};
    Double3 middle{}, with_x{}, with_y{};  // with_x, with_y: covariances of the points with the film positions
    for (const Double3& point : points) middle = add(middle, scaled(point, 1 / n));
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Double3 offset = scaled(subtract(points[i], middle), 1 / n);
        with_x = add(with_x, scaled(offset, positions[i][0]));
        with_y = add(with_y, scaled(offset, positions[i][1]));
    }
    // Multiplies by the inverse of the covariance matrix of the positions, or by its pseudo-inverse if they lie on a
    // line.
    if (determinant <= 1e-6 * trace * trace) {
        const double s = 1 / (trace * trace);
        return {add(scaled(with_x, p.xx * s), scaled(with_y, p.xy * s)),
                add(scaled(with_x, p.xy * s), scaled(with_y, p.yy * s))};
    }
    return {add(scaled(with_x, p.yy / determinant), scaled(with_y, -p.xy / determinant)),
            add(scaled(with_x, -p.xy / determinant), scaled(with_y, p.xx / determinant))};
}

bool find_common_patch(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp) {
    std::vector<PixelSample>& rays = block.rays;
    if (rays.size() != 4 || spp != 1) return false;
    const RayEnd& end = *rays[0].end;
    if (end.status != Status::hit || is_scattered(rays[0]) || !hit_same_face(geometry, rays[0], rays[1]) ||
        !hit_same_face(geometry, rays[0], rays[2]) || !hit_same_face(geometry, rays[0], rays[3]))
        return false;
    // Diagonals of the block: from its upper left to its lower right pixel, and from its lower left to its upper right.
    const Double3 falling = subtract(point_of(rays[3]), point_of(rays[0])),
                  rising = subtract(point_of(rays[1]), point_of(rays[2]));
    const Patch patch{scaled(add(falling, rising), 0.5), scaled(subtract(falling, rising), 0.5)};
    for (PixelSample& ray : rays) ray.patch = patch;
    return true;
}

void find_patches(const SceneGeometry& geometry, PixelBlock& block, std::uint32_t spp) {
    // Edge of the part of a pixel that one ray covers, in pixels.
    const double ray_size = 1 / std::sqrt(static_cast<double>(spp));
    std::vector<PixelSample>& rays = block.rays;
    block.has_patch.assign(rays.size(), false);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const RayEnd& end = *rays[ray].end;
        if (is_scattered(rays[ray])) rays[ray].patch = {};
        if (end.status != Status::hit || block.has_patch[ray] || is_scattered(rays[ray])) continue;
        block.group.clear();
        block.group_points.clear();
        block.group_positions.clear();
        for (std::size_t i = 0; i < rays.size(); ++i)
            if (hit_same_face(geometry, rays[ray], rays[i])) {
                block.group.push_back(i);
                block.group_points.push_back(point_of(rays[i]));
                block.group_positions.push_back(block.film_positions[i]);
            }
        const Patch pixel_patch = fit_patch(block.group_points, block.group_positions);
        const Patch patch{scaled(pixel_patch.right, ray_size), scaled(pixel_patch.below, ray_size)};
        for (const std::size_t i : block.group)
            if (!block.has_patch[i]) {  // on a mesh, a ray may be in two groups; it keeps its first patch
                rays[i].patch = patch;
                block.has_patch[i] = true;
            }
    }
}

}  // namespace kagero
