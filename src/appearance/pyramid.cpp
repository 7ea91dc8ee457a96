#include "appearance/pyramid.h"

#include "scene/vector3.h"

#include <algorithm>
#include <numbers>

namespace kagero {
namespace {

constexpr double max_probes = 16;  ///< Maximum number of probes per colour.

/// Adds `weight` times the `count` values at `from` to the values at `to`.
void accumulate(float* to, const float* from, double weight, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += static_cast<float>(weight) * from[i];
}

/// Divides an interval into n source cells and into m ≤ n target cells, and calls visit(source, target, overlap) for
/// every overlapping pair. The length of the overlap is in source cells.
template <class Visit>
void for_overlaps(int n, int m, const Visit& visit) {
    const double ratio = static_cast<double>(n) / m;
    for (int target = 0; target < m; ++target) {
        const double begin = target * ratio, end = std::min<double>((target + 1) * ratio, n);
        for (int source = static_cast<int>(begin); source < end; ++source)
            visit(source, target, std::min<double>(end, source + 1) - std::max<double>(begin, source));
    }
}

/// Returns the image reduced to `width` columns.
Image with_columns(const Image& image, int width) {
    Image result{width, image.height,
                 std::vector<float>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(image.height))};
    const double weight = static_cast<double>(width) / image.width;  // weight of one source column in a target column
    for (int y = 0; y < image.height; ++y) {
        const float* from = &image.rgb[3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width)];
        float* to = &result.rgb[3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
        for_overlaps(image.width, width, [&](int source, int target, double overlap) {
            accumulate(to + 3 * target, from + 3 * source, overlap * weight, 3);
        });
    }
    return result;
}

/// Returns the image reduced to `height` rows. Source rows are weighted by their areas. On a sphere, the area of a row
/// is proportional to the difference of the sines of the latitudes of its edges.
Image with_rows(const Image& image, int height, Mapping mapping) {
    const auto row = 3 * static_cast<std::size_t>(image.width);
    Image result{image.width, height, std::vector<float>(row * static_cast<std::size_t>(height))};
    const auto area = [mapping](double top, double bottom, int rows) {
        if (mapping == Mapping::plane) return (bottom - top) / rows;
        return std::cos(std::numbers::pi * top / rows) - std::cos(std::numbers::pi * bottom / rows);
    };
    const double ratio = static_cast<double>(image.height) / height;
    for_overlaps(image.height, height, [&](int source, int target, double) {
        const double top = std::max<double>(source, target * ratio),
                     bottom = std::min<double>(source + 1, (target + 1) * ratio);
        const double weight = area(top, bottom, image.height) / area(target, target + 1, height);
        accumulate(&result.rgb[static_cast<std::size_t>(target) * row],
                   &image.rgb[static_cast<std::size_t>(source) * row], weight, row);
    });
    return result;
}

/// Returns the colour at `uv`, interpolated between the two levels next to `level`. Level 0 is the image, and level i
/// is coarser[i − 1].
Float3 trilinear(const Image& image, const std::vector<Image>& coarser, const std::array<double, 2>& uv, double level,
                 Edges edges) {
    const auto [u, v] = uv;
    const auto color_at = [&, u = u, v = v](std::size_t i) {
        return texture_color(i ? coarser[i - 1] : image, u, v, edges);
    };
    const double last_level = static_cast<double>(coarser.size());
    if (!(level > 0)) return color_at(0);  // also if `level` is NaN
    if (level >= last_level) return color_at(coarser.size());
    const auto fine = static_cast<std::size_t>(level);
    const auto weight = static_cast<float>(level - static_cast<double>(fine));
    Float3 color = color_at(fine);
    const Float3 next = color_at(fine + 1);
    for (std::size_t k = 0; k < 3; ++k) color[k] += weight * (next[k] - color[k]);
    return color;
}

/// Returns the probes for a stripe on a sphere whose length and width are in radians. A texel counts as wide as the
/// shorter side of a texel on the equator. Texels near the poles are narrower along the rows, but the image resolves no
/// finer detail there.
Probes probes_on_sphere(const Image& image, double length, double width) {
    const double texel = std::min(std::numbers::pi / image.height, 2 * std::numbers::pi / image.width);
    return {length / texel, width / texel};
}

/// Returns the mean of the image along a stripe. position(t) returns u and v on the stripe's axis for t from −½ to ½.
template <class Position>
Float3 mean_along(const Image& image, const std::vector<Image>& coarser, const Probes& probes, Edges edges,
                  const Position& position) {
    if (probes.count == 1) return trilinear(image, coarser, position(0), probes.level, edges);
    Float3 color{};
    const double spacing = 1.0 / probes.count;
    for (int i = 0; i < probes.count; ++i) {
        const Float3 probe = trilinear(image, coarser, position((i + 0.5) * spacing - 0.5), probes.level, edges);
        for (std::size_t k = 0; k < 3; ++k) color[k] += probe[k];
    }
    for (float& channel : color) channel *= static_cast<float>(spacing);
    return color;
}

}  // namespace

Probes::Probes(double length, double width) {
    const double step = std::max({width, length / max_probes, 1.0});  // distance of probes, at most
    if (step > 1) level = std::log2(step);
    if (length > step) count += static_cast<int>(length / step * (1 - 1e-9));
}

SkyFilter sky_filter(const Image& image, const Footprint& footprint) {
    return {footprint, probes_on_sphere(image, length(footprint.major), length(footprint.minor))};
}

std::vector<Image> coarser_images(const Image& image, Mapping mapping) {
    std::vector<Image> images;
    for (const Image* last = &image; last->width > 1 || last->height > 1; last = &images.back()) {
        Image next = with_columns(*last, std::max(1, last->width / 2));
        images.push_back(with_rows(next, std::max(1, last->height / 2), mapping));
    }
    return images;
}

Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const SkyFilter& filter) {
    const auto [u, v] = sky_coordinates(direction, axes);
    if (filter.probes.count == 1) return trilinear(image, coarser, {u, v}, filter.probes.level, repeat_along_u);
    // The stripe lies on a great circle. If u and v are linear along it within a quarter of a texel, their derivatives
    // are used.
    const Double3& along = filter.footprint.major;
    const double east = dot(direction, axes.east), zero = dot(direction, axes.zero), square = dot(along, along),
                 from_axis = std::sqrt(east * east + zero * zero), texel = std::numbers::pi / image.height;
    if (square < 2 * texel * from_axis) {
        const double across = 0.5 / (std::numbers::pi * from_axis);
        const double du = across / from_axis * (east * dot(along, axes.zero) - zero * dot(along, axes.east)),
                     dv = 2 * across * dot(along, axes.up);
        return mean_along(image, coarser, filter.probes, repeat_along_u,
                          [&, u = u, v = v](double t) { return std::array{u + t * du, v + t * dv}; });
    }
    return mean_along(image, coarser, filter.probes, repeat_along_u, [&](double t) {
        return sky_coordinates(unit(add(direction, scaled(along, t))), axes);
    });
}

Float3 sphere_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below) {
    const double inverse = 1 / length(from_center);
    const Double3 outward = scaled(from_center, inverse);
    const auto [e1, e2] = axes_around(outward);
    const PrincipalAxes axes = principal_axes(
        {{dot(right, e1) * inverse, dot(right, e2) * inverse}, {dot(below, e1) * inverse, dot(below, e2) * inverse}});
    const Double3 major = add(scaled(e1, axes.major[0]), scaled(e2, axes.major[1]));
    const Probes probes = probes_on_sphere(image, axes.major_length, axes.minor_length);
    return mean_along(image, coarser, probes, repeat_along_u, [&](double t) {
        const ChartPoint point = sphere_uv(t == 0 ? outward : add(outward, scaled(major, t)));
        return std::array{point.u, point.v};
    });
}

Float3 surface_texture_color(const Image& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges) {
    const double columns = image.width, rows = image.height;
    const PrincipalAxes axes =
        principal_axes({{patch.a[0] * columns, patch.a[1] * rows}, {patch.b[0] * columns, patch.b[1] * rows}});
    return mean_along(image, coarser, {axes.major_length, axes.minor_length}, edges, [&](double t) {
        return std::array<double, 2>{u + t * axes.major[0] / columns, v + t * axes.major[1] / rows};
    });
}

}  // namespace kagero
