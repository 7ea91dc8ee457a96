#include "spaces/circular_orbits.h"

#include "geometry/shapes.h"
#include "scene/vector3.h"
#include "spaces/rest_frame.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Returns g(∂_t, ∂_t), g(∂_t, ∂_φ) and g(∂_φ, ∂_φ) at q, with ∂_φ = axis × (q − center); NaN where there is no metric.
std::array<double, 3> killing_products(const Space& space, const Double3& center, const Double3& axis,
                                       const Double3& q) {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    SpacetimeMatrix g;
    if (metric_at(space, {q[0], q[1], q[2]}, g) != Failure::none) return {undefined, undefined, undefined};
    const Double3 turn = cross(axis, subtract(q, center));
    const std::array<double, 4> time{0, 0, 0, 1}, around{turn[0], turn[1], turn[2], 0};
    return {product(g, time, time), product(g, time, around), product(g, around, around)};
}

/// Returns the greater root Ω of slope_tt + 2Ω slope_tφ + Ω² slope_φφ = 0; NaN if there is none.
double angular_velocity(const std::array<double, 3>& slopes) {
    const auto [a, b, c] = slopes;
    return (-b + std::sqrt(b * b - a * c)) / c;
}

/// A linear map that keeps a point fixed: a rotation about an axis, or the reflection at the plane perpendicular to it.
struct SymmetryMap {
    Double3 axis;
    double cosine, sine;  ///< Cosine and sine of the angle of the rotation.
    double along;         ///< Factor of the component along the axis: 1, or −1 for a reflection.

    Double3 operator()(const Double3& v) const {
        const double height = dot(v, axis);
        const Double3 across = subtract(v, scaled(axis, height));
        return add(add(scaled(across, cosine), scaled(cross(axis, v), sine)), scaled(axis, along * height));
    }
};

/// Returns true if the metric at map(q) is the image of the metric at q, up to rounding, or if both are undefined.
/// Increments `tested` if they are defined.
bool maps_metric(const Space& space, const Double3& center, const SymmetryMap& map, const Double3& q, int& tested) {
    constexpr double tolerance = 1e-8;
    const Double3 image = add(center, map(subtract(q, center)));
    SpacetimeMatrix g, mapped;
    const bool defined = metric_at(space, {q[0], q[1], q[2]}, g) == Failure::none,
               image_defined = metric_at(space, {image[0], image[1], image[2]}, mapped) == Failure::none;
    if (!defined || !image_defined) return defined == image_defined;
    ++tested;
    std::array<std::array<double, 4>, 4> basis{}, image_basis{};
    double greatest = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        basis[i][i] = image_basis[i][i] = 1;
        if (i == 3) continue;
        const Double3 column = map({basis[i][0], basis[i][1], basis[i][2]});
        std::copy(column.begin(), column.end(), image_basis[i].begin());
    }
    for (const auto& row : g)
        for (const double entry : row) greatest = std::max(greatest, std::abs(entry));
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
            const double expected = product(g, basis[a], basis[b]),
                         actual = product(mapped, image_basis[a], image_basis[b]);
            if (!(std::abs(expected - actual) <= tolerance * greatest)) return false;
        }
    return true;
}

/// Returns the reason why the space is not symmetric about the axis and the plane of the disk; "" if it is. The metric
/// is compared at points near the disk and at their images.
std::string missing_symmetry(const Space& space, const Double3& center, const Double3& axis, double inner,
                             double outer) {
    constexpr int points = 12;
    const auto [e1, e2] = axes_around(axis);
    int tested = 0;
    for (int i = 0; i < points; ++i) {
        const double radius = inner * std::pow(outer / inner, (i + 0.5) / points), phi = 2.39996 * i,
                     height = radius * (((7 * i) % points + 0.5) / points - 0.5), angle = 1 + 1.7 * i;
        const Double3 across = add(scaled(e1, radius * std::cos(phi)), scaled(e2, radius * std::sin(phi))),
                      q = add(center, add(across, scaled(axis, height)));
        if (!maps_metric(space, center, {axis, std::cos(angle), std::sin(angle), 1}, q, tested))
            return "the space is not symmetric about the axis of the disk";
        if (!maps_metric(space, center, {axis, 1, 0, -1}, q, tested))
            return "the space is not symmetric about the plane of the disk";
    }
    return tested > 0 ? "" : "H is not that of light in a spacetime";
}

}  // namespace

CircularOrbits::CircularOrbits(const Space& space, const Double3& center, const Double3& normal, double inner,
                               double outer)
    : searched_(true), center_(center), axis_(unit(normal)), outward_(axes_around(axis_)[0]), inner_(inner),
      outer_(outer), refusal_(missing_symmetry(space, center_, axis_, inner, outer)) {
    if (!refusal_.empty()) return;
    for (std::size_t i = 0; i < node_count; ++i) nodes_.push_back(slopes_at(space, radius_of(double(i))));
    find_gaps(space);
}

double CircularOrbits::radius_of(double node) const {
    return inner_ * std::pow(outer_ / inner_, node / double(node_count - 1));
}

// Central differences of fourth order. Slopes that are not greater than their rounding errors are 0, so that matter in
// flat space is at rest.
CircularOrbits::Slopes CircularOrbits::slopes_at(const Space& space, double radius) const {
    constexpr double step = 2e-3, rounding = 1e-11;
    const auto products_at = [&](double r) {
        return killing_products(space, center_, axis_, add(center_, scaled(outward_, r)));
    };
    const auto far_before = products_at(radius * (1 - 2 * step)), before = products_at(radius * (1 - step)),
               after = products_at(radius * (1 + step)), far_after = products_at(radius * (1 + 2 * step));
    Slopes slopes;
    for (std::size_t i = 0; i < 3; ++i) {
        const double difference = 8 * (after[i] - before[i]) - (far_after[i] - far_before[i]);
        slopes[i] = difference / (12 * step * radius);
        const double scale = (std::abs(before[i]) + std::abs(after[i])) / radius;
        if (std::abs(slopes[i]) <= rounding * scale) slopes[i] = 0;
    }
    return slopes;
}

// Cubic interpolation in the logarithm of the radius.
CircularOrbits::Slopes CircularOrbits::interpolated_slopes(double radius) const {
    const double node = std::clamp(std::log(radius / inner_) / std::log(outer_ / inner_), 0.0, 1.0) * (node_count - 1);
    const double first = std::clamp(std::floor(node) - 1, 0.0, double(node_count - 4)), x = node - first;
    const double weights[4] = {-(x - 1) * (x - 2) * (x - 3) / 6, x * (x - 2) * (x - 3) / 2,
                               -x * (x - 1) * (x - 3) / 2, x * (x - 1) * (x - 2) / 6};
    Slopes slopes{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t i = 0; i < 3; ++i) slopes[i] += weights[k] * nodes_[std::size_t(first) + k][i];
    return slopes;
}

bool CircularOrbits::exists(const Space& space, double radius) const {
    const double omega = angular_velocity(interpolated_slopes(radius));
    const auto [tt, tphi, phiphi] =
        killing_products(space, center_, axis_, add(center_, scaled(outward_, radius)));
    return tt + 2 * omega * tphi + omega * omega * phiphi < 0;
}

void CircularOrbits::find_gaps(const Space& space) {
    constexpr int bisections = 30;
    bool before = exists(space, inner_);
    if (!before) gaps_.push_back({inner_, outer_});
    for (std::size_t i = 1; i < node_count; ++i) {
        const bool now = exists(space, radius_of(double(i)));
        if (now == before) continue;
        double low = radius_of(double(i - 1)), high = radius_of(double(i));
        for (int k = 0; k < bisections; ++k) {
            const double middle = 0.5 * (low + high);
            (exists(space, middle) == before ? low : high) = middle;
        }
        if (now) gaps_.back()[1] = high;
        else gaps_.push_back({high, outer_});
        before = now;
    }
}

Double3 CircularOrbits::velocity(const Double3& q) const {
    constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
    if (!searched_ || !refusal_.empty()) return {undefined, undefined, undefined};
    const Double3 around = cross(axis_, subtract(q, center_));
    return scaled(around, angular_velocity(interpolated_slopes(length(around))));
}

}  // namespace kagero
