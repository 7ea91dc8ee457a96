/// Light rays around Kerr's black hole, integrated in Boyer–Lindquist coordinates as a reference for tests. Lengths are
/// in units of the mass M. The equations are separated (Carter 1968) and use Mino's time s (Mino 2003), with
/// dλ = (r² + a² cos²θ) ds. Let E = −p_t, L = p_φ, Q be Carter's constant, K = Q + (L − aE)², Δ = r² − 2r + a², and
/// u = 1/r:
///
///     (dr/ds)² = P² − ΔK,  P = E(r² + a²) − aL,  or  (du/ds)² = U(u),  a polynomial in u
///     n = (sin θ cos χ, sin θ sin χ, cos θ),  dχ/ds = L/sin²θ,  d²n/ds² = a²E² n_z e_z − (Q + L² + 2a²E² n_z²) n
///     φ = χ + δ,  dδ/ds = −aE + aP/Δ
///
/// All right-hand sides are regular at turning points and on the axis. The azimuth of a ray that starts inside the
/// horizon is the ingoing one, which is regular where the ray leaves the hole.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace kagero::test {

using Real = long double;

/// A ray: its constants, scaled so that |E| = 1, and its state at one place.
class KerrGeodesic {
public:
    /// The integrated quantities: u, du/ds, n, dn/ds, and δ.
    using State = std::array<Real, 9>;

    /// Makes the ray with the momentum (p, p_t) at q. The state is that of outgoing Kerr–Schild coordinates, or of
    /// ingoing ones if `ingoing` is true. Only rays inside the horizon, or that move outward, may be ingoing.
    KerrGeodesic(Real spin, const double (&q)[3], const double (&p)[3], double pt, bool ingoing)
        : a(spin), E(pt > 0 ? -1 : 1), ingoing_(ingoing) {
        const Real sign = ingoing ? -1 : 1, b = Real(q[0]) * q[0] + Real(q[1]) * q[1] + Real(q[2]) * q[2] - a * a;
        const Real r = std::sqrt((b + std::sqrt(b * b + 4 * a * a * q[2] * q[2])) / 2), sum = r * r + a * a;
        // (x, y, z) = (r n_x ± a n_y, r n_y ∓ a n_x, r n_z), and the momentum of n is the transposed map of p.
        const Real n[3] = {(r * q[0] - sign * a * q[1]) / sum, (r * q[1] + sign * a * q[0]) / sum, q[2] / r};
        const Real scale = 1 / std::abs(Real(pt)), px = scale * p[0], py = scale * p[1], pz = scale * p[2];
        const Real pn[3] = {r * px - sign * a * py, sign * a * px + r * py, r * pz};
        const Real along = pn[0] * n[0] + pn[1] * n[1] + pn[2] * n[2];
        const Real m[3] = {pn[0] - along * n[0], pn[1] - along * n[1], pn[2] - along * n[2]};
        const Real p_r = n[0] * px + n[1] * py + n[2] * pz;
        set_constants(n, m);
        radial_speed_ = (r * r - 2 * r + a * a) * p_r + sign * (2 * r * E - a * L);
        start = {1 / r, -radial_speed_ / (r * r), n[0], n[1], n[2], m[0], m[1], m[2], 0};
    }

    /// Makes a ray with E = −1 of which only the constants, the radius and the sense of the radial motion matter.
    KerrGeodesic(Real spin, Real r, bool outward, Real angular_momentum, Real carter)
        : a(spin), E(-1), L(angular_momentum), Q(carter), K(carter + (L + spin) * (L + spin)),
          b_(-spin * spin - spin * L), radial_speed_(outward ? 1 : -1) {
        start[0] = 1 / r;
    }

    /// Returns the ray from the same place whose dn/ds differs by ε |dr/ds, dn/ds| in the given tangential direction, 0
    /// or 1. Energy and sense of motion are the same.
    KerrGeodesic turned(int direction, Real epsilon) const {
        KerrGeodesic other = *this;
        const Real n[3] = {start[2], start[3], start[4]};
        const Real axis[3] = {n[2] * n[2] < 0.5L ? 0.L : 1.L, 0, n[2] * n[2] < 0.5L ? 1.L : 0.L};
        const Real along = axis[0] * n[0] + axis[2] * n[2];
        Real t[3] = {axis[0] - along * n[0], -along * n[1], axis[2] - along * n[2]};
        if (direction == 1) {
            const Real x = t[0], y = t[1], z = t[2];
            t[0] = n[1] * z - n[2] * y;
            t[1] = n[2] * x - n[0] * z;
            t[2] = n[0] * y - n[1] * x;
        }
        const Real length = std::hypot(t[0], t[1], t[2]), r = 1 / start[0],
                   size = std::hypot(std::hypot(start[5], start[6], start[7]), radial_speed_ / r);
        Real m[3];
        for (int k = 0; k < 3; ++k) m[k] = start[5 + k] + epsilon * size * t[k] / length;
        other.set_constants(n, m);
        std::copy_n(m, 3, other.start.begin() + 5);
        other.start[1] = std::copysign(std::sqrt(std::max(other.potential(start[0]), Real(0))), start[1]);
        other.radial_speed_ = -r * r * other.start[1];
        return other;
    }

    /// Returns U(u) = (du/ds)².
    Real potential(Real u) const {
        const Real A = E + b_ * u * u;
        return A * A - u * u * (1 - 2 * u + a * a * u * u) * K;
    }
    /// Returns the least U between u0 and u1. The zeros of dU/du are those of u times a quadratic polynomial.
    Real least_potential(Real u0, Real u1) const {
        Real least = std::min(potential(u0), potential(u1));
        const Real c2 = 2 * E * b_ - K, c3 = 2 * K, c4 = b_ * b_ - a * a * K, root = 9 * c3 * c3 - 32 * c2 * c4;
        if (root < 0) return least;
        // Both zeros of 4 c4 u² + 3 c3 u + 2 c2, without cancellation.
        const Real half = -(3 * c3 + std::copysign(std::sqrt(root), c3)) / 2;
        for (const Real u : {half / (4 * c4), 2 * c2 / half})
            if (u > u0 && u < u1) least = std::min(least, potential(u));
        return least;
    }
    Real horizon() const { return 1 + std::sqrt(1 - a * a); }
    Real start_radius() const { return 1 / start[0]; }
    bool starts_outward() const { return radial_speed_ > 0; }
    /// Returns how far the ray is from critical: U(u) at the place that decides whether it escapes. The ray escapes if
    /// the result is positive.
    Real escape_margin() const {
        const Real u0 = start[0], on_horizon = 1 / horizon();
        if (E > 0) return -1;
        if (u0 >= on_horizon && E * (horizon() * horizon() + a * a) - a * L > 0) return -1;
        const Real outside = least_potential(0, std::min(u0, on_horizon) * (1 - 1e-15L));
        return starts_outward() ? outside : std::min(outside, -least_potential(u0, on_horizon));
    }

    /// Position and direction dq/dλ in the coordinates of the scene.
    struct Place {
        Real q[3], v[3];
    };
    /// Returns the place of a state. Outside the horizon it is in outgoing coordinates, else in ingoing ones.
    Place place(const State& y) const {
        const Real u = y[0], r = 1 / u, rate = -y[1] * r * r, A = E + b_ * u * u, D = 1 - 2 * u + a * a * u * u;
        const bool inside = r <= horizon();
        const Real sign = inside ? -1 : 1;
        const Real angle =
            y[8] + (ingoing_ ? 0 : -winding(start_radius())) + (inside ? 0 : (ingoing_ ? 2 : 1) * winding(r));
        const Real turn = inside ? ingoing_rate(y) : -a * E + a * (A + y[1]) / D;
        const Real c = std::cos(angle), s = std::sin(angle);
        const Real dx = y[5] - turn * y[3], dy = y[6] + turn * y[2];
        const Real n[3] = {c * y[2] - s * y[3], s * y[2] + c * y[3], y[4]};
        const Real m[3] = {c * dx - s * dy, s * dx + c * dy, y[7]};
        Place at{{r * n[0] + sign * a * n[1], r * n[1] - sign * a * n[0], r * n[2]},
                 {rate * n[0] + r * m[0] + sign * a * m[1], rate * n[1] + r * m[1] - sign * a * m[0],
                  rate * n[2] + r * m[2]}};
        const Real length = std::hypot(at.v[0], at.v[1], at.v[2]);
        for (Real& component : at.v) component /= length;
        return at;
    }

    /// Follows the ray until beyond(q) > 0. Steps are at most `longest`. Returns false if the ray reaches the horizon
    /// from outside before.
    bool follow(const std::function<Real(const Real (&)[3])>& beyond, Real longest, Place& end) const {
        constexpr Real tolerance = 1e-15L;
        State y = start;
        Real h = longest;
        for (int i = 0; i < 100000; ++i) {
            Real error;
            const State next = step(y, h, error);
            if (!(error <= tolerance && next[0] > 0)) {
                h /= 2;
                continue;
            }
            if (next[1] > 0 && next[0] * horizon() > 1 - 1e-9L) return false;
            if (beyond(place(next).q) > 0) {
                end = place(locate(y, h, beyond));
                return true;
            }
            y = next;
            if (error < 1e-4L * tolerance) h = std::min(2 * h, longest);
        }
        return false;
    }

    Real a, E, L = 0, Q = 0, K = 0;  ///< The constants.
    State start{};

private:
    void set_constants(const Real (&n)[3], const Real (&m)[3]) {
        L = n[0] * m[1] - n[1] * m[0];
        Q = m[0] * m[0] + m[1] * m[1] + m[2] * m[2] - L * L - a * a * n[2] * n[2];
        K = Q + (L - a * E) * (L - a * E);
        b_ = a * a * E - a * L;
    }
    /// Returns ∫_r^∞ a dr/Δ, the angle from the Boyer–Lindquist azimuth to the outgoing one.
    Real winding(Real r) const {
        const Real outer = horizon(), width = 2 * (outer - 1);
        return a * (width > 0 ? std::log1p(width / (r - outer)) / width : 1 / (r - outer));
    }
    /// Returns dδ/ds of the ingoing azimuth. The form without Δ is regular at the horizon for outward motion.
    Real ingoing_rate(const State& y) const {
        const Real u = y[0], A = E + b_ * u * u;
        return y[1] < 0 ? -a * E - a * K * u * u / (-y[1] - A) : -a * E + a * (A - y[1]) / (1 - 2 * u + a * a * u * u);
    }
    State derivative(const State& y) const {
        const Real u = y[0], A = E + b_ * u * u, D = 1 - 2 * u + a * a * u * u, pull = a * a * y[4],
                   spring = Q + L * L + 2 * a * a * y[4] * y[4];
        return {y[1],
                2 * b_ * A * u - u * D * K + u * u * (1 - a * a * u) * K,
                y[5],
                y[6],
                y[7],
                -spring * y[2],
                -spring * y[3],
                pull - spring * y[4],
                ingoing_ ? ingoing_rate(y) : -a * E + a * A / D};
    }
    /// Returns the state after n steps of the modified midpoint rule with the total length h.
    State midpoint(const State& y, Real h, int n) const {
        const Real length = h / n;
        State before = y, now = y, rate = derivative(y);
        for (std::size_t k = 0; k < y.size(); ++k) now[k] += length * rate[k];
        for (int i = 1; i < n; ++i) {
            rate = derivative(now);
            for (std::size_t k = 0; k < y.size(); ++k) {
                const Real next = before[k] + 2 * length * rate[k];
                before[k] = now[k];
                now[k] = next;
            }
        }
        rate = derivative(now);
        for (std::size_t k = 0; k < y.size(); ++k) now[k] = (now[k] + before[k] + length * rate[k]) / 2;
        return now;
    }
    /// Returns the state after a step of the length h, by extrapolation to infinitely many midpoint steps (Gragg 1965;
    /// Bulirsch & Stoer 1966). Sets `error` to the last change of the extrapolation.
    State step(const State& y, Real h, Real& error) const {
        constexpr int columns = 8;
        std::array<State, columns> table;
        for (int i = 0; i < columns; ++i) {
            table[i] = midpoint(y, h, 2 * (i + 1));
            for (int j = i - 1; j >= 0; --j) {
                const Real ratio = Real(i + 1) / Real(j + 1);
                for (std::size_t k = 0; k < y.size(); ++k)
                    table[j][k] = table[j + 1][k] + (table[j + 1][k] - table[j][k]) / (ratio * ratio - 1);
            }
        }
        error = 0;
        for (std::size_t k = 0; k < y.size(); ++k) error = std::max(error, std::abs(table[0][k] - table[1][k]));
        return table[0];
    }
    /// Returns the state at the zero of beyond(q) in a step.
    State locate(const State& y, Real h, const std::function<Real(const Real (&)[3])>& beyond) const {
        Real low = 0, high = h, g_low = beyond(place(y).q), error;
        State at = step(y, h, error);
        Real g_high = beyond(place(at).q);
        for (int i = 0; i < 60 && high - low > 1e-17L * h; ++i) {
            const Real s = i % 3 == 2 ? (low + high) / 2 : low - g_low * (high - low) / (g_high - g_low);
            at = step(y, s, error);
            const Real g = beyond(place(at).q);
            if (std::abs(g) < 1e-17L) break;
            (g > 0 ? high : low) = s;
            (g > 0 ? g_high : g_low) = g;
        }
        return at;
    }

    bool ingoing_ = false;
    Real b_ = 0;             ///< a²E − aL
    Real radial_speed_ = 0;  ///< dr/ds at the start
};

}  // namespace kagero::test
