#include "appearance/pyramid.h"

#include "scene/vector3.h"

#include <algorithm>
#include <numbers>

namespace kagero {
namespace {

constexpr double most_probes = 16;

/// Adds `weight` × (a run of `count` × rgb) to another.
void accumulate(float* to, const float* from, double weight, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) to[i] += static_cast<float>(weight) * from[i];
}

/// Calls visit(source, target, overlap) for the cells of n that the cells of m < n cover; overlaps are in cells of n.
template <class Visit>
void for_overlaps(int n, int m, const Visit& visit) {
    const double ratio = static_cast<double>(n) / m;
    for (int target = 0; target < m; ++target) {
        const double begin = target * ratio, end = std::min<double>((target + 1) * ratio, n);
        for (int source = static_cast<int>(begin); source < end; ++source)
            visit(source, target, std::min<double>(end, source + 1) - std::max<double>(begin, source));
    }
}

Image narrower(const Image& image, int width) {
    Image result{width, image.height,
                 std::vector<float>(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(image.height))};
    const double share = static_cast<double>(width) / image.width;
    for (int y = 0; y < image.height; ++y) {
        const float* from = &image.rgb[3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width)];
        float* to = &result.rgb[3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(width)];
        for_overlaps(image.width, width, [&](int source, int target, double overlap) {
            accumulate(to + 3 * target, from + 3 * source, overlap * share, 3);
        });
    }
    return result;
}

/// A row's share of the sphere goes with the sines of its edges' latitudes.
Image lower(const Image& image, int height, Mapping mapping) {
    const auto row = 3 * static_cast<std::size_t>(image.width);
    Image result{image.width, height, std::vector<float>(row * static_cast<std::size_t>(height))};
    const auto band = [mapping](double top, double bottom, int rows) {
        if (mapping == Mapping::plane) return (bottom - top) / rows;
        return std::cos(std::numbers::pi * top / rows) - std::cos(std::numbers::pi * bottom / rows);
    };
    const double ratio = static_cast<double>(image.height) / height;
    for_overlaps(image.height, height, [&](int source, int target, double) {
        const double top = std::max<double>(source, target * ratio),
                     bottom = std::min<double>(source + 1, (target + 1) * ratio);
        const double share = band(top, bottom, image.height) / band(target, target + 1, height);
        accumulate(&result.rgb[static_cast<std::size_t>(target) * row],
                   &image.rgb[static_cast<std::size_t>(source) * row], share, row);
    });
    return result;
}

/// Level 0 is the image itself.
Float3 trilinear(const Image& image, const std::vector<Image>& coarser, const std::array<double, 2>& place,
                 double level, Edges edges) {
    const auto [u, v] = place;
    const auto at = [&, u = u, v = v](std::size_t i) { return texture_color(i ? coarser[i - 1] : image, u, v, edges); };
    const double last = static_cast<double>(coarser.size());
    if (!(level > 0)) return at(0);  // as where it is not a number
    if (level >= last) return at(coarser.size());
    const auto fine = static_cast<std::size_t>(level);
    const auto share = static_cast<float>(level - static_cast<double>(fine));
    Float3 color = at(fine);
    const Float3 next = at(fine + 1);
    for (std::size_t k = 0; k < 3; ++k) color[k] += share * (next[k] - color[k]);
    return color;
}

/// A line with a width, in lengths of a texel: what an average is taken over.
struct Stripe {
    double along, across;

    Stripe(double full_length, double width)
        : along(full_length), across(std::max({width, full_length / most_probes, 1.0})) {}
    int probes() const { return std::max(1, static_cast<int>(std::ceil(along / across - 1e-9))); }
};

/// Of radians, in the shorter of a texel's sides on the equator. Towards the poles an image of a sphere holds nothing
/// finer along its rows than across.
Stripe stripe_on_sphere(const Image& image, double along, double across) {
    const double texel = std::min(std::numbers::pi / image.height, 2 * std::numbers::pi / image.width);
    return {along / texel, across / texel};
}
Stripe stripe_of(const Image& image, const Footprint& footprint) {
    return stripe_on_sphere(image, length(footprint.major), length(footprint.minor));
}

/// place(t) is where the line is at t in −½…½.
template <class Line>
Float3 mean_along(const Image& image, const std::vector<Image>& coarser, const Stripe& stripe, Edges edges,
                  const Line& place) {
    const double level = std::log2(stripe.across);
    const int probes = stripe.probes();
    if (probes == 1) return trilinear(image, coarser, place(0), level, edges);
    Float3 color{};
    for (int i = 0; i < probes; ++i) {
        const Float3 seen = trilinear(image, coarser, place((i + 0.5) / probes - 0.5), level, edges);
        for (std::size_t k = 0; k < 3; ++k) color[k] += seen[k] / static_cast<float>(probes);
    }
    return color;
}

}  // namespace

std::vector<Image> coarser_images(const Image& image, Mapping mapping) {
    std::vector<Image> images;
    for (const Image* last = &image; last->width > 1 || last->height > 1; last = &images.back()) {
        Image next = narrower(*last, std::max(1, last->width / 2));
        images.push_back(lower(next, std::max(1, last->height / 2), mapping));
    }
    return images;
}

Float3 sky_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const Footprint& footprint) {
    return mean_along(image, coarser, stripe_of(image, footprint), around, [&](double t) {
        return sky_coordinates(t == 0 ? direction : unit(add(direction, scaled(footprint.major, t))), axes);
    });
}

Float3 sphere_texture_color(const Image& image, const std::vector<Image>& coarser, const Double3& from_center,
                            const Double3& right, const Double3& below) {
    const double inverse = 1 / length(from_center);
    const Double3 out = scaled(from_center, inverse);
    const auto [e1, e2] = meridians(out);
    const PrincipalAxes axes = principal_axes(
        {{dot(right, e1) * inverse, dot(right, e2) * inverse}, {dot(below, e1) * inverse, dot(below, e2) * inverse}});
    const Double3 major = add(scaled(e1, axes.major[0]), scaled(e2, axes.major[1]));
    return mean_along(image, coarser, stripe_on_sphere(image, axes.along, axes.across), around, [&](double t) {
        const ChartPoint at = on_sphere(t == 0 ? out : add(out, scaled(major, t)));
        return std::array{at.u, at.v};
    });
}

int sky_probes(const Image& image, const Footprint& footprint) {
    return stripe_of(image, footprint).probes();
}

Float3 surface_texture_color(const Image& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges) {
    const double columns = image.width, rows = image.height;
    const PrincipalAxes axes =
        principal_axes({{patch.a[0] * columns, patch.a[1] * rows}, {patch.b[0] * columns, patch.b[1] * rows}});
    return mean_along(image, coarser, {axes.along, axes.across}, edges, [&](double t) {
        return std::array<double, 2>{u + t * axes.major[0] / columns, v + t * axes.major[1] / rows};
    });
}

}  // namespace kagero
