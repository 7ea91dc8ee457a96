#include "appearance/sky_view.h"

#include "error.h"
#include "formula/nodes.h"
#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/rest_frame.h"
#include "spaces/velocity.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Computes the metric at q, in a spacetime. Returns false if there is none.
bool sky_metric(const Skies& skies, const double (&q)[3], SpacetimeMatrix& g) {
    return skies.formula ? metric_of_formula(*skies.formula, q, g) : metric_at(*skies.space, q, g) == Failure::none;
}

/// Returns the light of a ray's end for the distant observers; nothing if they would not be slower than light.
std::optional<ObservedLight> light_at_sky(const Skies& skies, const RayEnd& end) {
    SpacetimeMatrix g;
    if (!sky_metric(skies, end.q, g)) return std::nullopt;
    auto frame = rest_frame(g, velocity_at(*skies.frame, end.q));
    if (!frame) return std::nullopt;
    if (skies.formula && skies.formula->parsed.pt < 0) frame->momentum_sign = -1;
    return observed_light(*frame, end.p, end.pt);
}

/// Returns the frequency of light with |p_t| = 1 for an observer at rest at infinity: the square root of the limit of
/// −∂²H/∂p_t² far away. It differs from 1 if H has a constant factor. Returns 1 if there is no limit, as in spaces that
/// are not flat at infinity. Values that differ from 1 by rounding errors and by the finite distance count as 1.
double frequency_at_infinity(const Space& space, double escape_radius) {
    constexpr double tolerance = 1e-6;
    constexpr Double3 directions[] = {{0.48, 0.6, 0.64}, {-0.8, 0.36, 0.48}, {0.6, -0.64, 0.48}, {0.36, 0.48, -0.8}};
    double limit = 0;
    for (const double distance : {1e8, 1e10})
        for (const Double3& direction : directions) {
            const Double3 q = scaled(direction, distance * escape_radius);
            StartMap frame{};
            if (space.observe(ObserverKind::coordinate, {q[0], q[1], q[2]}, false, frame) != Failure::none) return 1;
            const double frequency = 1 / std::abs(frame.offset[3]);  // the offset is −u_a ∝ ∂t/∂x^a
            if (limit == 0) limit = frequency;
            if (!(frequency > 0) || !(std::abs(frequency - limit) <= tolerance * limit)) return 1;
        }
    return std::abs(limit - 1) <= tolerance ? 1 : limit;
}

bool is_far(const Skies& skies, const RayEnd& end) {
    return !(evaluate(skies.formula->scope, skies.formula->far_domain_node,
                      {end.q[0], end.q[1], end.q[2], 0, 0, 0, end.pt}) > 0);
}

/// Returns the distance at which rays end in a direction from the centre: the escape radius, or less if the domain of a
/// formula ends before.
double distance_to_edge(const Skies& skies, const Double3& direction, double escape_radius) {
    constexpr double factor = 0.95, least = 1e-6;
    constexpr int bisections = 40;
    if (!skies.formula || skies.formula->parsed.domain < 0) return escape_radius;
    const Formula& parsed = skies.formula->parsed;
    const auto is_in_domain = [&](double distance) {
        const Double3 q = scaled(direction, distance);
        return evaluate(skies.formula->scope, parsed.domain, {q[0], q[1], q[2], 0, 0, 0, parsed.pt}) > 0;
    };
    double inner = escape_radius, outer = escape_radius;
    for (; !is_in_domain(inner); inner *= factor) {
        if (inner < least * escape_radius) return escape_radius;
        outer = inner;
    }
    for (int i = 0; i < bisections && inner < outer; ++i) {
        const double middle = 0.5 * (inner + outer);
        (is_in_domain(middle) ? inner : outer) = middle;
    }
    return inner;
}

/// Returns the end of a ray of light at q with dq/dλ along v. Its momentum is g_ab k^b, where k^i = v^i, and k^t is a
/// root of g_ab k^a k^b = 0; `sign` is 1 or −1 and selects the root. Returns nothing if there is no root or no metric.
std::optional<RayEnd> light_end(const Skies& skies, const Double3& q, const Double3& v, double sign) {
    RayEnd end{};
    std::copy(q.begin(), q.end(), end.q);
    std::copy(v.begin(), v.end(), end.v);
    SpacetimeMatrix g;
    if (!sky_metric(skies, end.q, g)) return std::nullopt;
    const std::array<double, 4> space_part{v[0], v[1], v[2], 0}, time_axis{0, 0, 0, 1};
    const double b = product(g, space_part, time_axis), c = product(g, space_part, space_part),
                 root = std::sqrt(b * b - g[3][3] * c), divisor = b + sign * root;
    if (!(std::abs(divisor) > 0)) return std::nullopt;
    const std::array<double, 4> k{v[0], v[1], v[2], -c / divisor};
    for (std::size_t i = 0; i < 4; ++i) {
        std::array<double, 4> axis{};
        axis[i] = 1;
        (i < 3 ? end.p[i] : end.pt) = product(g, axis, k);
    }
    return end;
}

/// Returns the cosine of the angle between the momenta of two rays, whose components are treated as Cartesian.
double cosine_of_momenta(const RayEnd& a, const RayEnd& b) {
    double product = a.pt * b.pt, square_a = a.pt * a.pt, square_b = b.pt * b.pt;
    for (int k = 0; k < 3; ++k) {
        product += a.p[k] * b.p[k];
        square_a += a.p[k] * a.p[k];
        square_b += b.p[k] * b.p[k];
    }
    return product / std::sqrt(square_a * square_b);
}

Double3 reflected(const Double3& d, const Double3& q) {
    const Double3 n = unit(q);
    return subtract(d, scaled(n, 2 * dot(d, n)));
}

}  // namespace

Skies make_skies(const Space& space, const SceneDescription& scene) {
    Skies skies{&space, space.throat_radius()};
    const auto& formula = scene.space.formula;
    if (formula) skies.formula = &*formula;
    if (scene.space.sky_frame) skies.frame = &*scene.space.sky_frame;
    if (formula) skies.frequency_at_rest = frequency_at_infinity(space, scene.integrator.escape_radius);
    return skies;
}

std::string check_sky_frame(const Skies& skies, double escape_radius, double length_unit) {
    constexpr int points = 52;
    int defined = 0, too_fast = 0;
    std::string problem;
    for (int i = 0; skies.frame && i < points; ++i) {
        const double height = 2 * (i + 0.5) / points - 1, width = std::sqrt(1 - height * height), angle = 2.39996 * i;
        const Double3 direction{width * std::cos(angle), width * std::sin(angle), height},
                      p = scaled(direction, distance_to_edge(skies, direction, escape_radius));
        const double q[3] = {p[0], p[1], p[2]};
        SpacetimeMatrix g;
        if (!sky_metric(skies, q, g)) continue;
        const Double3 v = velocity_at(*skies.frame, q);
        ++defined;
        if (rest_frame(g, v)) continue;
        ++too_fast;
        problem = "space.sky_frame = " + text_of(*skies.frame, q) + " is not slower than light at " +
                  to_toml(scaled(p, length_unit)) + ", where rays end: " + speed_limit(g, v);
    }
    if (too_fast == 0) return "";
    if (too_fast == defined) throw InputError(skies.frame->location, problem);
    return problem + ". Where it is not, the sky is looked up along dq/dλ, and its redshift is 0";
}

SkyView sky_view(double throat_radius, const Double3& q, const Double3& d) {
    if (!(length(q) < throat_radius)) return {false, d};
    return {true, reflected(d, q), true};
}

SkyView sky_view(const Skies& skies, const RayEnd& end) {
    const Double3 q{end.q[0], end.q[1], end.q[2]}, v{end.v[0], end.v[1], end.v[2]};
    ObservedLight light{0, v};
    if (skies.frame) light = light_at_sky(skies, end).value_or(light);
    SkyView view{false, light.direction};
    if (!skies.has_far_domain()) view = sky_view(skies.throat_radius, q, light.direction);
    else if (is_far(skies, end)) {
        const bool inward = dot(q, v) < 0;
        view = {true, inward ? reflected(light.direction, q) : light.direction, inward};
    }
    view.frequency = light.frequency;
    return view;
}

std::optional<SkyDerivatives> sky_derivatives(const Skies& skies, const RayEnd& end) {
    constexpr double relative_step = 1e-4;
    if (!skies.frame || !light_at_sky(skies, end)) return std::nullopt;
    const Double3 q{end.q[0], end.q[1], end.q[2]}, v{end.v[0], end.v[1], end.v[2]};
    // One of the two roots for the time component reproduces the momentum of the ray, up to a factor.
    double sign = 1, cosine = 0;
    for (const double candidate : {1.0, -1.0}) {
        const auto light = light_end(skies, q, v, candidate);
        const double found = light ? cosine_of_momenta(*light, end) : 0;
        if (std::abs(found) <= std::abs(cosine)) continue;
        sign = candidate;
        cosine = found;
    }
    const auto direction_at = [&](const Double3& position, const Double3& direction) {
        auto light = light_end(skies, position, direction, sign);
        if (!light || !light_at_sky(skies, *light)) return Double3{NAN, NAN, NAN};
        for (double& p : light->p) p = std::copysign(1, cosine) * p;
        light->pt = std::copysign(1, cosine) * light->pt;
        return sky_view(skies, *light).direction;
    };
    SkyDerivatives derivatives;
    for (std::size_t k = 0; k < 3; ++k) {
        Double3 change{}, shift{};
        change[k] = relative_step * length(v);
        shift[k] = relative_step * length(q);
        derivatives.by_direction[k] =
            scaled(subtract(direction_at(q, add(v, change)), direction_at(q, subtract(v, change))),
                   0.5 / relative_step);
        derivatives.by_position[k] =
            scaled(subtract(direction_at(add(q, shift), v), direction_at(subtract(q, shift), v)), 0.5 / shift[k]);
    }
    return derivatives;
}

double frequency_at_sky(const Skies& skies, const RayEnd& end) {
    if (!skies.frame) return skies.frequency_at_rest * std::abs(end.pt);
    const auto light = light_at_sky(skies, end);
    return light ? light->frequency : 0;
}

}  // namespace kagero
