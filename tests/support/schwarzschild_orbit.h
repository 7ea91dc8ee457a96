/// Light around a Schwarzschild hole in closed form, for tests to compare with. Lengths in r_g, u = 1/r, p_t = 1,
/// impact parameter b.
///
/// The orbit is (du/dφ)² = P(u) = 1/b² − u² + u³ (Chandrasekhar 1983, §20). For b > b_c it has the real roots u_a < 0 <
/// u_b < u_c, and with u = u_a + (u_b − u_a) sin²ψ the angle is φ = 2 F(ψ | k) / √(u_c − u_a), k² = (u_b − u_a)/(u_c −
/// u_a).
#pragma once

#include "render/render.h"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero::test {

inline const double critical_impact = 1.5 * std::sqrt(3.0);

/// Components of dq/dλ along the radius and across it at radius r, ingoing: with p_⊥ = b/r and H = 0, dr/dλ = (1−f) p_r
/// − f is ∓√(1 − (1−f) b²/r²), f = 1/r.
struct Velocity {
    double along, aside;
};
inline Velocity ingoing(double b, double r) {
    return {-std::sqrt(1 - (1 - 1 / r) * b * b / (r * r)), b / r};
}

/// The orbit of a ray that turns back, b > b_c.
struct Orbit {
    double b, ua, ub, uc;

    explicit Orbit(double impact) : b(impact) {
        // Three real roots, u = 1/3 + (2/3) cos(…) (Viète); in long double, because u_b and u_c nearly meet at b_c.
        const long double third = std::acos(1.0L - 13.5L / (static_cast<long double>(b) * b)) / 3;
        const auto root = [&](int k) {
            return static_cast<double>((1 + 2 * std::cos(third - 2 * std::numbers::pi_v<long double> * k / 3)) / 3);
        };
        uc = root(0), ub = root(1), ua = root(2);
    }
    double modulus() const { return std::sqrt((ub - ua) / (uc - ua)); }
    double rate() const { return 0.5 * std::sqrt(uc - ua); }
    /// Angle from u_a's end of the parametrisation to u.
    double phase(double u) const {
        return boost::math::ellint_1(modulus(), std::asin(std::sqrt(std::min(1.0, (u - ua) / (ub - ua))))) / rate();
    }
    /// Angle swept inward from radius r0 to r1, both outside the turning point.
    double swept(double r0, double r1) const { return phase(1 / r1) - phase(1 / r0); }
    /// Angle swept from r0 to the turning point and out again to r0.
    double swept_around(double r0) const { return 2 * (boost::math::ellint_1(modulus()) / rate() - phase(1 / r0)); }
    /// Radius after an angle swept from r0, inward at first.
    double radius_after(double r0, double angle) const {
        const double s = boost::math::jacobi_sn(modulus(), rate() * (phase(1 / r0) + angle));
        return 1 / (ua + (ub - ua) * s * s);
    }
    /// dq/dλ there: dφ/dλ = b u², so dr/dλ = −b du/dφ, without a root that loses digits where the ray turns.
    Velocity velocity_after(double r0, double angle) const {
        double cn, dn;
        const double sn = boost::math::jacobi_elliptic(modulus(), rate() * (phase(1 / r0) + angle), &cn, &dn);
        return {-b * 2 * (ub - ua) * sn * cn * dn * rate(), b / radius_after(r0, angle)};
    }
};

/// The same angle without elliptic functions: ∫ du/√P for a piece that ends before the turning point.
inline double swept_by_quadrature(double b, double r0, double r1) {
    boost::math::quadrature::tanh_sinh<double> rule;
    return rule.integrate([b](double u) { return 1 / std::sqrt(1 / (b * b) - u * u * (1 - u)); }, 1 / r0, 1 / r1);
}

/// And to the turning point, where P vanishes: u = u_b − w² takes the square root out of it.
inline double swept_around_by_quadrature(const Orbit& o, double r0) {
    boost::math::quadrature::tanh_sinh<double> rule;
    const double end = std::sqrt(o.ub - 1 / r0);
    return 2 * rule.integrate([&o](double w) { return 2 / std::sqrt((o.ub - w * w - o.ua) * (o.uc - o.ub + w * w)); },
                              0.0, end);
}

/// A plane through the hole's centre, spanned by two unit vectors; φ counts from `outward` towards `across`.
struct OrbitPlane {
    Double3 outward, across;

    Double3 at(double along, double aside) const {
        Double3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = along * outward[k] + aside * across[k];
        return x;
    }
    double angle_of(const Double3& x) const {
        double along = 0, aside = 0;
        for (std::size_t k = 0; k < 3; ++k) along += x[k] * outward[k], aside += x[k] * across[k];
        return std::atan2(aside, along);
    }
};

/// A ray at radius r0 in direction `outward` of a plane, moving inward with impact parameter b.
inline RayInput ray_inward(const OrbitPlane& plane, double b, double r0, const Double3& center) {
    const Velocity v = ingoing(b, r0);
    RayInput ray{plane.at(r0, 0), plane.at(v.along, v.aside)};
    for (std::size_t k = 0; k < 3; ++k) ray.position[k] += center[k];
    return ray;
}

}  // namespace kagero::test
