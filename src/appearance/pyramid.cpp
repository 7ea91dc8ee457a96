#include "appearance/pyramid.h"

#include "scene/vector3.h"

#include <algorithm>
#include <numbers>
#include <type_traits>

namespace kagero {
namespace {

constexpr double max_probes = 16;  ///< Maximum number of probes per colour.

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

/// Returns the area of a part of an image with `rows` rows. On a sphere, it is proportional to the difference of the
/// sines of the latitudes of the edges.
double band_area(Mapping mapping, double top, double bottom, int rows) {
    if (mapping == Mapping::plane) return (bottom - top) / rows;
    return std::cos(std::numbers::pi * top / rows) - std::cos(std::numbers::pi * bottom / rows);
}

/// The level of an image that is finer than a stripe, and the next one. Level 0 is the image, and level i is
/// coarser[i − 1]. `Stored` is the type of the components of the finer level.
template <class Stored>
struct LevelPair {
    Texels<Stored> fine;
    const Image* next;  ///< Null if only the finer level is used.
    float weight = 0;   ///< Weight of the next level.

    /// Returns the colour at `uv`, interpolated between the two levels.
    Float3 color(const std::array<double, 2>& uv, Edges edges) const {
        Float3 color = texture_color(fine, uv[0], uv[1], edges);
        if (!next) return color;
        const Float3 coarse = texture_color(texels_of(*next), uv[0], uv[1], edges);
        for (std::size_t k = 0; k < 3; ++k) color[k] += weight * (coarse[k] - color[k]);
        return color;
    }
};

/// Calls visit(LevelPair) with the two levels next to `level`, and returns its result. Level 0 is `image`.
template <class Stored, class Visit>
Float3 visit_levels(const Texels<Stored>& image, const std::vector<Image>& coarser, double level, const Visit& visit) {
    const double last_level = static_cast<double>(coarser.size());
    if (!(level > 0) || coarser.empty()) return visit(LevelPair<Stored>{image, nullptr});  // also if `level` is NaN
    if (level >= last_level) return visit(LevelPair<float>{texels_of(coarser.back()), nullptr});
    const auto fine = static_cast<std::size_t>(level);
    const auto weight = static_cast<float>(level - static_cast<double>(fine));
    const Image* const next = &coarser[fine];
    if (fine == 0) return visit(LevelPair<Stored>{image, next, weight});
    return visit(LevelPair<float>{texels_of(coarser[fine - 1]), next, weight});
}

/// Loads the texels around (u, v) in two levels into the cache.
template <class Stored>
void prefetch(const Texels<Stored>& image, const std::vector<Image>& coarser, double level, double u, double v) {
    visit_levels(image, coarser, level, [&](const auto& levels) {
        prefetch_texels(levels.fine, u, v);
        if (levels.next) prefetch_texels(texels_of(*levels.next), u, v);
        return Float3{};
    });
}

/// Returns the probes for a stripe on a sphere whose length and width are in radians. A texel counts as wide as the
/// shorter side of a texel on the equator. Texels near the poles are narrower along the rows, but the image resolves no
/// finer detail there.
Probes probes_on_sphere(const StoredImage& image, double length, double width) {
    const double texel = texel_on_sphere(image);
    return {length / texel, width / texel};
}

/// Returns the position of a probe on a stripe, from −½ to ½.
double place_of_probe(int i, int count) { return (i + 0.5) * (1.0 / count) - 0.5; }

/// Returns the mean of the image over probes. position_of(i) returns u and v of probe i.
template <class Stored, class Position>
Float3 mean_over(const Texels<Stored>& image, const std::vector<Image>& coarser, const Probes& probes, Edges edges,
                 const Position& position_of) {
    return visit_levels(image, coarser, probes.level, [&](const auto& levels) {
        if (probes.count == 1) return levels.color(position_of(0), edges);
        Float3 color{};
        for (int i = 0; i < probes.count; ++i) {
            const Float3 probe = levels.color(position_of(i), edges);
            for (std::size_t k = 0; k < 3; ++k) color[k] += probe[k];
        }
        for (float& channel : color) channel *= static_cast<float>(1.0 / probes.count);
        return color;
    });
}

/// Returns the mean of the image along a stripe. position(t) returns u and v on the stripe's axis for t from −½ to ½.
template <class Stored, class Position>
Float3 mean_along(const Texels<Stored>& image, const std::vector<Image>& coarser, const Probes& probes, Edges edges,
                  const Position& position) {
    if (probes.count == 1) return mean_over(image, coarser, probes, edges, [&](int) { return position(0); });
    return mean_over(image, coarser, probes, edges,
                     [&](int i) { return position(place_of_probe(i, probes.count)); });
}
/// The same for an image whose type of components is distinguished by this call.
template <class Position>
Float3 mean_along(const StoredImage& image, const std::vector<Image>& coarser, const Probes& probes, Edges edges,
                  const Position& position) {
    return visit_texels(image,
                        [&](const auto& texels) { return mean_along(texels, coarser, probes, edges, position); });
}

/// Returns the mean along a stripe on a great circle of the sky, with the middle `direction` and the axis `along`.
template <class AnyImage>
[[gnu::noinline]] Float3 mean_along_great_circle(const AnyImage& image, const std::vector<Image>& coarser,
                                                 const Double3& direction, const Double3& along, const SkyAxes& axes,
                                                 const Probes& probes) {
    return mean_along(image, coarser, probes, repeat_along_u,
                      [&](double t) { return sky_coordinates(unit(add(direction, scaled(along, t))), axes); });
}

/// The texture coordinates of the probes of stripes that are not straight in u and v. They lie on great circles of the
/// sky, and the kernel module computes those of all probes of a stripe in one call.
class BentStripe {
public:
    explicit BentStripe(const SkyPoints& points) : stripes_(points), probes_(points) {
        probes_.count = max_count;
        probes_.level = nullptr;
        for (std::size_t k = 0; k < 3; ++k) {
            probes_.direction[k] = direction_[k].data();
            probes_.major[k] = probes_.minor[k] = zero_.data();
        }
        probes_.u = uv_[0].data();
        probes_.v = uv_[1].data();
        probes_.by_major[0] = probes_.by_major[1] = probes_.by_minor[0] = probes_.by_minor[1] = unused_.data();
        probes_.bend = unused_.data();
    }
    /// Returns u and v of the probes of stripe i.
    const std::array<std::array<double, 16>, 2>& probe_positions(const Module& module, std::size_t i, int count) {
        for (std::size_t probe = 0; probe < max_count; ++probe) {
            const double t = place_of_probe(std::min(static_cast<int>(probe), count - 1), count);
            for (std::size_t k = 0; k < 3; ++k)
                direction_[k][probe] = stripes_.direction[k][i] + t * stripes_.major[k][i];
        }
        module.shading.sky_points(&probes_);
        return uv_;
    }

private:
    static constexpr std::uint32_t max_count = 16;
    static_assert(max_count == max_probes && max_count % shading_lanes == 0);

    const SkyPoints& stripes_;
    SkyPoints probes_;
    std::array<std::array<double, max_count>, 3> direction_;
    std::array<std::array<double, max_count>, 2> uv_;
    std::array<double, max_count> zero_{}, unused_;
};

}  // namespace

Probes::Probes(double length, double width) {
    const double step = std::max({width, length / max_probes, 1.0});  // distance of probes, at most
    if (step > 1) level = std::log2(step);
    if (length > step) count += static_cast<int>(length / step * (1 - 1e-9));
}

double texel_on_sphere(const StoredImage& image) {
    return std::min(std::numbers::pi / image.height, 2 * std::numbers::pi / image.width);
}

SkyFilter sky_filter(const StoredImage& image, const Footprint& footprint) {
    return {footprint, probes_on_sphere(image, length(footprint.major), length(footprint.minor))};
}

ImageReduction::ImageReduction(int width, int height, Mapping mapping) {
    while (width > 1 || height > 1) {
        const int columns = std::max(1, width / 2), rows = std::max(1, height / 2);
        Level level{{columns, rows, {}}, {}, {}};
        level.image.rgb.resize(3 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
        level.reduced_row.resize(3 * static_cast<std::size_t>(columns));
        const double column_weight = static_cast<double>(columns) / width;
        for_overlaps(width, columns, [&](int source, int target, double overlap) {
            level.columns.push_back({source, target, static_cast<float>(overlap * column_weight)});
        });
        const double ratio = static_cast<double>(height) / rows;
        for_overlaps(height, rows, [&](int source, int target, double) {
            const double top = std::max<double>(source, target * ratio),
                         bottom = std::min<double>(source + 1, (target + 1) * ratio);
            const double weight =
                band_area(mapping, top, bottom, height) / band_area(mapping, target, target + 1, rows);
            level.rows.push_back({source, target, static_cast<float>(weight)});
        });
        levels_.push_back(std::move(level));
        width = columns;
        height = rows;
    }
}

void ImageReduction::add_row(std::size_t index, const float* row) {
    if (index == levels_.size()) return;
    Level& level = levels_[index];
    std::fill(level.reduced_row.begin(), level.reduced_row.end(), 0.0f);
    for (const auto& [source, target, weight] : level.columns)
        for (int c = 0; c < 3; ++c) level.reduced_row[std::size_t(3 * target + c)] += weight * row[3 * source + c];
    const int source_row = level.source_rows++;
    for (; level.next < level.rows.size() && level.rows[level.next].source == source_row; ++level.next) {
        const auto& [source, target, weight] = level.rows[level.next];
        const std::size_t size = level.reduced_row.size();
        float* const to = &level.image.rgb[size * static_cast<std::size_t>(target)];
        for (std::size_t i = 0; i < size; ++i) to[i] += weight * level.reduced_row[i];
        const bool is_complete = level.next + 1 == level.rows.size() || level.rows[level.next + 1].target != target;
        if (is_complete) add_row(index + 1, to);
    }
}

void ImageReduction::add_rows(const StoredImage& image, int end) {
    visit_texels(image, [&](const auto& texels) {
        const std::size_t size = 3 * static_cast<std::size_t>(texels.width);
        std::vector<float> row(size);
        for (; added_rows_ < end; ++added_rows_) {
            const std::size_t begin = size * static_cast<std::size_t>(added_rows_);
            for (std::size_t i = 0; i < size; ++i) row[i] = texels[begin + i];
            add_row(0, row.data());
        }
    });
}

std::vector<Image> ImageReduction::take_images() {
    std::vector<Image> images;
    for (Level& level : levels_) images.push_back(std::move(level.image));
    return images;
}

std::vector<Image> coarser_images(const StoredImage& image, Mapping mapping) {
    ImageReduction reduction(image.width, image.height, mapping);
    reduction.add_rows(image, image.height);
    return reduction.take_images();
}

ImageLevelTable::ImageLevelTable(const StoredImage& image, const std::vector<Image>& coarser) {
    visit_texels(image, [&](const auto& texels) {
        using Stored = std::remove_cvref_t<decltype(*texels.stored)>;
        using enum ImageLevels::Components;
        components_ = std::is_same_v<Stored, float> ? floats : sizeof(Stored) == 1 ? bytes : words;
        linear_ = texels.linear;
        levels_.push_back({texels.stored, texels.width, texels.height});
    });
    for (const Image& level : coarser) levels_.push_back({level.rgb.data(), level.width, level.height});
}

ImageLevels ImageLevelTable::levels(Edges edges) const {
    return {components_,
            edges.along_u == BeyondEdge::repeat,
            edges.along_v == BeyondEdge::repeat,
            linear_,
            static_cast<std::uint32_t>(levels_.size()),
            levels_.data()};
}

Float3 sky_texture_color(const StoredImage& image, const std::vector<Image>& coarser, const Double3& direction,
                         const SkyAxes& axes, const SkyFilter& filter) {
    const auto [u, v] = sky_coordinates(direction, axes);
    if (filter.probes.count == 1)
        return mean_along(image, coarser, filter.probes, repeat_along_u,
                          [&, u = u, v = v](double) { return std::array{u, v}; });
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
    return mean_along_great_circle(image, coarser, direction, along, axes, filter.probes);
}

void sky_texture_colors(const StoredImage& image, const std::vector<Image>& coarser, const Module& module,
                        const SkyPoints& points, std::span<Float3> colors) {
    BentStripe bent(points);
    visit_texels(image, [&](const auto& texels) {
        for (std::size_t i = 0; i < colors.size(); ++i)
            prefetch(texels, coarser, points.level[i], points.u[i], points.v[i]);
        for (std::size_t i = 0; i < colors.size(); ++i) {
            Probes probes;
            probes.level = points.level[i];
            probes.count = static_cast<int>(points.probes[i]);
            const std::array middle{points.u[i], points.v[i]}, side{points.by_major[0][i], points.by_major[1][i]};
            if (probes.count == 1 || points.bend[i] < 1)
                colors[i] = mean_along(texels, coarser, probes, repeat_along_u, [&](double t) {
                    return std::array{middle[0] + t * side[0], middle[1] + t * side[1]};
                });
            else
                colors[i] = mean_over(texels, coarser, probes, repeat_along_u,
                                      [&, uv = bent.probe_positions(module, i, probes.count)](int probe) {
                                          const auto k = static_cast<std::size_t>(probe);
                                          return std::array{uv[0][k], uv[1][k]};
                                      });
        }
    });
}

Float3 sphere_texture_color(const StoredImage& image, const std::vector<Image>& coarser, const Double3& from_center,
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

Float3 surface_texture_color(const StoredImage& image, const std::vector<Image>& coarser, double u, double v,
                             const UvPatch& patch, Edges edges) {
    const double columns = image.width, rows = image.height;
    const PrincipalAxes axes =
        principal_axes({{patch.a[0] * columns, patch.a[1] * rows}, {patch.b[0] * columns, patch.b[1] * rows}});
    return mean_along(image, coarser, {axes.major_length, axes.minor_length}, edges, [&](double t) {
        return std::array<double, 2>{u + t * axes.major[0] / columns, v + t * axes.major[1] / rows};
    });
}

}  // namespace kagero
