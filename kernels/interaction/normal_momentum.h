/// The momentum of a ray that leaves a surface. A surface with the unit normal n changes only the part of the momentum
/// along n: p' = p + α n. The factor α is such that H(q, p') = H0 on the side where the ray continues, and that the ray
/// moves to that side: n·∂H/∂p' > 0. With the H of the other side, this is Snell's law; with the H of the same side, it
/// is the law of reflection. Both hold for any H (Kravtsov & Orlov 1990, Geometrical Optics of Inhomogeneous Media,
/// §2.4: the eikonal is continuous on the surface, and with it the tangential part of its gradient p).
#pragma once

#include "kernels/autodiff/dual.h"
#include "kernels/numeric/vec.h"

#include <limits>

namespace kagero {

/// H − H0 along the normal, with its first and second derivative.
template <class V>
struct NormalLine {
    V value, slope, curvature;
};

/// The solution for each lane.
template <class V>
struct NormalMomentum {
    V alpha;           ///< The momentum is p + alpha·n.
    V curvature;       ///< Second derivative of H along n at this momentum.
    MaskOf<V> exists;  ///< False in lanes where no momentum along n satisfies both conditions.
};

/// Solves for α. `at(s)` returns the NormalLine at p + s·n; `scale` > 0 is a typical momentum.
template <class V, class At>
class NormalMomentumSolver {
    using S = ScalarOf<V>;
    using Line = NormalLine<V>;

public:
    NormalMomentumSolver(const At& at, const V& scale) : at_(at), scale_(scale) {}

    NormalMomentum<V> solve() const {
        const Line here = at_(V(S(0)));
        V alpha = quadratic_root(here);
        MaskOf<V> exists = is_finite(alpha);
        const Line away = at_(V(S(0.7310586)) * scale_);
        Line line = at_(select(exists, alpha, V(S(0))));
        // H is quadratic along n if its curvature is the same at three momenta, and if the root is one of H.
        const MaskOf<V> general =
            !(has_curvature_of(here, away) & has_curvature_of(here, line) & ((!exists) | is_root(line)));
        if (any(general)) {
            const Root found = search(here);
            alpha = select(general, found.alpha, alpha);
            exists = (general & found.exists) | ((!general) & exists);
            line = at_(select(exists, alpha, V(S(0))));
        }
        const V correction = line.value / line.slope;
        const MaskOf<V> improves = (abs(correction) <= V(S(1e-6)) * scale_) & (abs(correction) > rounding() * scale_);
        alpha = select(exists, select(improves, alpha - correction, alpha), V(S(0)));
        return {alpha, line.curvature, exists & (line.slope > V(S(0))) & is_finite(line.slope)};
    }

private:
    struct Root {
        V alpha;
        MaskOf<V> exists;
    };

    /// Relative distance of two momenta that differ only by rounding.
    static V rounding() { return V(S(64) * machine_epsilon<S>); }
    static MaskOf<V> has_curvature_of(const Line& one, const Line& other) {
        return abs(other.curvature - one.curvature) <= V(S(1e-10)) * (abs(other.curvature) + abs(one.curvature));
    }
    /// True if the line is close to a root, where H − H0 is small.
    MaskOf<V> is_root(const Line& line) const {
        return abs(line.value) <= V(S(1e-6)) * scale_ * (abs(line.slope) + abs(line.curvature) * scale_);
    }
    /// Returns the root of a quadratic H at which the slope is positive, NaN or infinity if there is none. The
    /// form of the root without cancellation is used.
    static V quadratic_root(const Line& here) {
        const V two(S(2)), discriminant = here.slope * here.slope - two * here.curvature * here.value;
        const V root = sqrt(discriminant);  // NaN if negative
        const V continuing = -two * here.value / (here.slope + root), returning = (root - here.slope) / here.curvature;
        return select(discriminant > V(S(0)), select(here.slope > V(S(0)), continuing, returning),
                      V(std::numeric_limits<S>::quiet_NaN()));
    }

    /// h(t) = ±(H − H0) at p ± t·n, with the sign for which h is convex near t = 0. The slope dh/dt is that of H, so
    /// the wanted root is the right one in both cases.
    struct Convex {
        const NormalMomentumSolver& solver;
        V sign;
        Line operator()(const V& t) const {
            const Line line = solver.at_(sign * t);
            return {sign * line.value, line.slope, sign * line.curvature};
        }
    };

    /// Finds the right root of a convex h by bracketing: a point with h < 0, a point with h > 0 on its right, and
    /// Newton's method between both, with bisection where Newton's method leaves the bracket.
    Root search(const Line& here) const {
        const V zero(S(0)), one(S(1));
        const Convex h{*this, select(here.curvature < zero, -one, one)};
        V below = zero;
        const MaskOf<V> exists = find_inside(h, below);
        V step = V(S(1e-3)) * scale_, above = below + step;
        MaskOf<V> bracketed = no_lanes<V>();
        for (int i = 0; i < max_doublings && any(exists & !bracketed); ++i) {
            const Line line = h(above);
            bracketed = bracketed | (line.value >= zero);
            step = step + step;
            below = select(bracketed | !(line.value < zero), below, above);
            above = select(bracketed, above, above + step);
        }
        return {h.sign * refine(h, below, above), exists & bracketed};
    }
    /// Finds a t with h(t) < 0. It is between t = 0 and the minimum of h, which lies in the direction in which h
    /// decreases. Returns the lanes with such a t.
    MaskOf<V> find_inside(const Convex& h, V& t) const {
        const V zero(S(0));
        Line line = h(t);
        MaskOf<V> inside = line.value < zero, crossed = no_lanes<V>();
        const V direction = select(line.slope < zero, V(S(1)), V(S(-1)));
        V near = zero, far = zero, step = direction * V(S(1e-6)) * scale_;
        for (int i = 0; i < max_doublings && any(!(inside | crossed)); ++i) {  // until h increases again
            far = select(inside | crossed, far, near + step);
            line = h(far);
            t = select((!inside) & (line.value < zero), far, t);
            inside = inside | (line.value < zero);
            crossed = crossed | (direction * line.slope >= zero) | !is_finite(line.slope);
            near = select(inside | crossed, near, far);
            step = step + step;
        }
        for (int i = 0; i < max_bisections && any(crossed & !inside); ++i) {  // the minimum is between near and far
            const V middle = V(S(0.5)) * (near + far);
            line = h(middle);
            t = select((!inside) & (line.value < zero), middle, t);
            inside = inside | (line.value < zero);
            const MaskOf<V> beyond = direction * line.slope >= zero;
            far = select(beyond, middle, far);
            near = select(beyond, near, middle);
        }
        return inside;
    }
    /// Returns the root between `below`, where h < 0, and `above`, where h ≥ 0.
    V refine(const Convex& h, V below, V above) const {
        const V zero(S(0)), half(S(0.5)), rounding(S(4) * machine_epsilon<S>);
        V t = half * (below + above);
        for (int i = 0; i < max_bisections; ++i) {
            const Line line = h(t);
            const MaskOf<V> is_below = line.value < zero;
            below = select(is_below, t, below);
            above = select(is_below, above, t);
            const V newton = t - line.value / line.slope, middle = half * (below + above);
            const V next = select((newton > below) & (newton < above), newton, middle);
            const MaskOf<V> converged = abs(next - t) <= rounding * (abs(t) + scale_);
            t = next;
            if (!any(!converged)) break;
        }
        return t;
    }

    static constexpr int max_doublings = 64, max_bisections = 64;
    const At& at_;
    V scale_;
};

}  // namespace kagero
