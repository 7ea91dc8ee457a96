/// Closed form of light rays around a Schwarzschild black hole, as a reference for tests. Lengths are in units of the
/// Schwarzschild radius r_g, u = 1/r, p_t = 1, and b is the impact parameter.
///
/// The orbit obeys (du/dφ)² = P(u) = 1/b² − u² + u³ (Chandrasekhar 1983, §20). For b > b_c, P has three real roots
/// u_a < 0 < u_b < u_c. With u = u_a + (u_b − u_a) sin²ψ, the angle is φ = 2 F(ψ | k) / √(u_c − u_a). The modulus is
/// given by k² = (u_b − u_a)/(u_c − u_a).
#pragma once

#include "render/render.h"

#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace kagero::test {

/// Critical impact parameter b_c: rays from far away with b < b_c are captured.
inline const double critical_impact = 1.5 * std::sqrt(3.0);

/// Components of dq/dλ: along the radius, and in the orbit plane normal to it.
struct Velocity {
    double radial, transverse;
};
/// Returns the velocity of an ingoing ray at radius r. With f = 1/r, p_⊥ = b/r and H = 0, the radial component
/// dr/dλ = (1 − f) p_r − f is −√(1 − (1 − f) b²/r²).
inline Velocity ingoing(double b, double r) {
    return {-std::sqrt(1 - (1 - 1 / r) * b * b / (r * r)), b / r};
}

/// The orbit of a ray that has a turning point (b > b_c). Angles are in radians and increase along the ray.
struct Orbit {
    double b, ua, ub, uc;

    explicit Orbit(double impact) : b(impact) {
        // Viète's formula for the three real roots. It is evaluated in long double, because u_b and u_c nearly coincide
        // for b close to b_c.
        const long double third = std::acos(1.0L - 13.5L / (static_cast<long double>(b) * b)) / 3;
        const auto root = [&](int k) {
            return static_cast<double>((1 + 2 * std::cos(third - 2 * std::numbers::pi_v<long double> * k / 3)) / 3);
        };
        uc = root(0);
        ub = root(1);
        ua = root(2);
    }
    /// Returns the modulus k of the elliptic integral.
    double modulus() const { return std::sqrt((ub - ua) / (uc - ua)); }
    /// Returns dF/dφ = √(u_c − u_a)/2.
    double rate() const { return 0.5 * std::sqrt(uc - ua); }
    /// Returns the angle φ that is swept from u_a, where ψ = 0, to u.
    double phase(double u) const {
        return boost::math::ellint_1(modulus(), std::asin(std::sqrt(std::min(1.0, (u - ua) / (ub - ua))))) / rate();
    }
    /// Returns the angle swept while the ray moves inward from r0 to r1. Both radii are outside the turning point.
    double swept(double r0, double r1) const { return phase(1 / r1) - phase(1 / r0); }
    /// Returns the angle swept from r0 to the turning point and out again to r0.
    double swept_around(double r0) const { return 2 * (boost::math::ellint_1(modulus()) / rate() - phase(1 / r0)); }
    /// Returns the radius after a ray that starts at r0 and moves inward has swept the given angle.
    double radius_after(double r0, double angle) const {
        const double s = boost::math::jacobi_sn(modulus(), rate() * (phase(1 / r0) + angle));
        return 1 / (ua + (ub - ua) * s * s);
    }
    /// Returns dq/dλ after the ray has swept the given angle. Since dφ/dλ = b u², dr/dλ = −b du/dφ. This form contains
    /// no square root, which would lose digits near the turning point.
    Velocity velocity_after(double r0, double angle) const {
        double cn, dn;
        const double sn = boost::math::jacobi_elliptic(modulus(), rate() * (phase(1 / r0) + angle), &cn, &dn);
        return {-b * 2 * (ub - ua) * sn * cn * dn * rate(), b / radius_after(r0, angle)};
    }
};

/// Returns the same angle as Orbit::swept by numerical quadrature of ∫ du/√P. The path must end before the turning
/// point.
inline double swept_by_quadrature(double b, double r0, double r1) {
    boost::math::quadrature::tanh_sinh<double> rule;
    return rule.integrate([b](double u) { return 1 / std::sqrt(1 / (b * b) - u * u * (1 - u)); }, 1 / r0, 1 / r1);
}

/// Returns the same angle as Orbit::swept_around by numerical quadrature. P vanishes at the turning point; the
/// substitution u = u_b − w² removes the singularity.
inline double swept_around_by_quadrature(const Orbit& o, double r0) {
    boost::math::quadrature::tanh_sinh<double> rule;
    const double end = std::sqrt(o.ub - 1 / r0);
    return 2 * rule.integrate([&o](double w) { return 2 / std::sqrt((o.ub - w * w - o.ua) * (o.uc - o.ub + w * w)); },
                              0.0, end);
}

/// A plane through the centre of the black hole, spanned by two orthogonal unit vectors. The angle φ is 0 in direction
/// `outward` and increases towards `across`.
struct OrbitPlane {
    Double3 outward, across;

    /// Returns the vector with the given components in the plane.
    Double3 at(double outward_part, double across_part) const {
        Double3 x;
        for (std::size_t k = 0; k < 3; ++k) x[k] = outward_part * outward[k] + across_part * across[k];
        return x;
    }
    /// Returns the angle φ of a vector's projection onto the plane, in (−π, π].
    double angle_of(const Double3& x) const {
        double outward_part = 0, across_part = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            outward_part += x[k] * outward[k];
            across_part += x[k] * across[k];
        }
        return std::atan2(across_part, outward_part);
    }
};

/// Returns a ray that starts at radius r0 in direction `outward` of a plane and moves inward with impact parameter b.
inline RayInput ray_inward(const OrbitPlane& plane, double b, double r0, const Double3& center) {
    const Velocity v = ingoing(b, r0);
    RayInput ray{plane.at(r0, 0), plane.at(v.radial, v.transverse)};
    for (std::size_t k = 0; k < 3; ++k) ray.position[k] += center[k];
    return ray;
}

}  // namespace kagero::test
