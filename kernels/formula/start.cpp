// The momentum a ray starts with, for any H: p with ∂H/∂p = μ d, μ > 0, and H = H0; and the metric, where H has one.
#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"
#include "kernels/numeric/linear_solve.h"

#include <cmath>

namespace kagero::formula {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double size(const Vector& a) { return std::sqrt(dot(a, a)); }
Vector moved(const Vector& a, double by, const Vector& along) {
    return {a[0] + by * along[0], a[1] + by * along[1], a[2] + by * along[2]};
}
double distance(const Vector& a, const Vector& b) { return size(moved(a, -1, b)); }

/// H − H0 at (q, p), with its first and second derivatives by p: by three, or with p_t by four.
template <std::size_t n>
struct Expansion {
    double value;
    std::array<double, n> gradient;
    Matrix<n> hessian;
    bool finite() const {
        double sum = value;
        for (std::size_t i = 0; i < n; ++i) {
            sum += gradient[i];
            for (std::size_t k = 0; k < n; ++k) sum += hessian[i][k];
        }
        return std::isfinite(sum);
    }
};

template <std::size_t n>
Expansion<n> expand(const Programs& programs, const double (&q)[3], const std::array<double, n>& p) {
    using First = Dual<double, n>;
    using Second = Dual<First, n>;
    Second in[state_size], out[1];
    for (int i = 0; i < space_size; ++i) in[i] = Second(q[i]);
    in[component_pt] = Second(programs.pt);
    for (std::size_t a = 0; a < n; ++a) in[component_px + a] = Second::variable(First::variable(p[a], int(a)), int(a));
    evaluate(programs.value, in, out);
    Expansion<n> e{out[0].value.value, out[0].value.derivative, {}};
    for (std::size_t a = 0; a < n; ++a) e.hessian[a] = out[0].derivative[a].derivative;
    return e;
}

/// H − H0 and its first derivatives by p: far cheaper than the whole expansion.
double slope(const Programs& programs, const double (&q)[3], const Vector& p, Vector& gradient) {
    using First = Dual<double, 3>;
    First in[state_size], out[1];
    for (int i = 0; i < space_size; ++i) in[i] = First(q[i]), in[momentum(i)] = First::variable(p[i], i);
    in[component_pt] = First(programs.pt);
    evaluate(programs.value, in, out);
    gradient = out[0].derivative;
    return out[0].value;
}

/// H's expansion to second order taken for H itself: p + G⁻¹(μ d − g), where H = H0 gives μ. Exact, from anywhere, for
/// H quadratic in p.
bool quadratic_step(const Expansion<3>& e, const Vector& d, Vector& p, double& mu) {
    std::array<Vector, 3> a = e.hessian, b = e.hessian;
    Vector along = d, against = e.gradient;
    solve_linear(3, a.data(), along.data()), solve_linear(3, b.data(), against.data());  // G⁻¹ d, G⁻¹ g
    const double square = 2 * (0.5 * dot(e.gradient, against) - e.value) / dot(d, along);
    if (!(square > 0) || !std::isfinite(square)) return false;
    mu = std::sqrt(square);
    for (int i = 0; i < 3; ++i) p[i] += mu * along[i] - against[i];
    return std::isfinite(dot(p, p));
}

/// Newton's method for the four unknowns p and μ: G δp − d δμ = μ d − g, g·δp = −(H − H0). What G says nothing of, and
/// needs no change, stays.
void newton_step(const Expansion<3>& e, const Vector& d, Vector& p, double& mu) {
    std::array<std::array<double, 4>, 4> a{};
    std::array<double, 4> b{};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) a[i][k] = e.hessian[i][k];
        a[i][i] += std::numeric_limits<double>::min();
        a[i][3] = -d[i], a[3][i] = e.gradient[i];
        b[i] = mu * d[i] - e.gradient[i];
    }
    b[3] = -e.value;
    solve_linear(4, a.data(), b.data());
    for (int i = 0; i < 3; ++i) p[i] += b[i];
    mu += b[3];
}

/// How far p is from a solution: both equations relative to their terms.
double residual(double value, const Vector& gradient, const Vector& d, const Vector& p, double level) {
    const double mu = dot(gradient, d);
    if (!(mu > 0)) return std::numeric_limits<double>::infinity();
    Vector rest;
    for (int i = 0; i < 3; ++i) rest[i] = gradient[i] - mu * d[i];
    return size(rest) / mu + std::abs(value) / (std::abs(dot(p, gradient)) + std::abs(level));
}

/// Polishes p until rounding stops it. False when it leads to no solution.
bool converge(const Programs& programs, const double (&q)[3], const Vector& d, Vector& p, double mu) {
    constexpr int most = 60;
    constexpr double enough = 1e-11, rounding = 1e-14;
    Vector gradient;
    const double value = slope(programs, q, p, gradient);
    if (residual(value, gradient, d, p, programs.level) < rounding) return true;  // as H quadratic in p has it at once
    double last = std::numeric_limits<double>::infinity();
    Vector best = p;
    for (int i = 0; i < most; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) break;
        const double now = residual(e.value, e.gradient, d, p, programs.level);
        if (now >= last && last < enough) break;
        if (now < last) best = p, last = now;
        if (now == 0) break;
        newton_step(e, d, p, mu);
    }
    p = best;
    return last < enough;
}

/// Where on the line from `c` along d, ahead (side 1) or behind (−1), H − H0 changes its sign, upward along d: how far,
/// on the innermost of such places; 0 where there are none.
double crossing(const Programs& programs, const double (&q)[3], const Vector& c, const Vector& d, double side) {
    constexpr double nearest = 1e-12, farthest = 1e12;
    const auto value = [&](double at) {
        Vector unused;
        return side * slope(programs, q, moved(c, side * at, d), unused);
    };
    double below = nearest, above = 2 * below;
    for (; above < farthest; below = above, above *= 2)
        if (value(below) < 0 && value(above) >= 0) break;
    if (!(above < farthest)) return 0;
    for (double middle; middle = 0.5 * (below + above), below < middle && middle < above;)
        (value(middle) < 0 ? below : above) = middle;
    return side * above;
}

/// A place within the level set of H0, from where it is crossed in every direction if it is convex: on the way from p =
/// 0 to where H is least, or greatest (side −1), by Newton's method. p = 0 where there is none.
Vector place_within(const Programs& programs, const double (&q)[3], double side) {
    constexpr int most = 100;
    Vector p{};
    for (int i = 0; i < most; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) break;
        if (side * e.value < 0) return p;
        std::array<Vector, 3> g = e.hessian;
        Vector step = e.gradient;
        for (int k = 0; k < 3; ++k) g[k][k] += std::numeric_limits<double>::min();
        solve_linear(3, g.data(), step.data());
        p = moved(p, -1, step);
    }
    return {};
}

/// Newton's method until its steps get no shorter, which along flat directions of H is long after the equations hold.
/// False when it does not come to rest nearby.
bool settle(const Programs& programs, const double (&q)[3], const Vector& d, Vector& p, double& mu) {
    constexpr int most = 16;
    constexpr double enough = 1e-8, rounding = 1e-13, farthest = 0.5, hardly_shorter = 0.5;
    const Vector first = p;
    double last = std::numeric_limits<double>::infinity();
    for (int i = 0; i < most; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) return false;
        const bool holds = residual(e.value, e.gradient, d, p, programs.level) < enough;
        Vector next = p;
        double next_mu = mu;
        newton_step(e, d, next, next_mu);
        const double step = distance(next, p);
        if (holds && (step <= rounding * size(p) || step >= hardly_shorter * last)) return true;
        p = next, mu = next_mu, last = step;
        if (!(distance(p, first) <= farthest * size(first))) return false;
    }
    return false;
}

/// Turns p, for which ∂H/∂p points along `from`, until it points along d: by small turns, each settled from the one
/// before. It comes where no guess along d is near, as with powers higher than squares. False where the turn comes to
/// an end before.
bool turn_to(const Programs& programs, const double (&q)[3], const Vector& from, const Vector& d, Vector& p,
             double& mu) {
    constexpr int most_turns = 100;  // each four times the one before, from the smallest that there is
    double done = 0, turn = 1;
    for (int n = 0; n < most_turns && done < 1 && done + turn > done; ++n) {
        const double share = std::min(1.0, done + turn);
        Vector target;
        for (int i = 0; i < 3; ++i) target[i] = (1 - share) * from[i] + share * d[i];
        const double length = size(target);
        for (double& component : target) component /= length;
        Vector tried = p;
        double tried_mu = mu;
        if (settle(programs, q, target, tried, tried_mu)) p = tried, mu = tried_mu, done = share, turn *= 4;
        else turn *= 0.125;
    }
    return done >= 1;
}

/// Whether e, at p, is what G says of a form without terms of lower degree.
bool is_form(const Expansion<4>& e, const Matrix<4>& g, const std::array<double, 4>& p) {
    constexpr double rounding = 1e-12;
    double value = 0, size = 0, off = 0;
    for (int a = 0; a < 4; ++a) {
        double slope = 0, terms = 0;
        for (int b = 0; b < 4; ++b) {
            slope += g[a][b] * p[b], terms += std::abs(g[a][b] * p[b]);
            off = std::max(off, std::abs(e.hessian[a][b] - g[a][b])), size = std::max(size, std::abs(g[a][b]));
        }
        value += 0.5 * p[a] * slope;
        if (!(std::abs(e.gradient[a] - slope) <= rounding * (terms + size))) return false;
    }
    return off <= rounding * size && std::abs(e.value - value) <= rounding * size;
}

}  // namespace

bool inverse_metric_of(const Programs& programs, const double (&q)[3], Matrix<4>& inverse_metric) {
    if (programs.level != 0 || !(programs.pt > 0)) return false;
    const std::array<double, 4> rest{0, 0, 0, 1}, moving{0.6, -0.3, 0.7, 0.8};
    const Expansion<4> at_rest = expand<4>(programs, q, rest);
    inverse_metric = at_rest.hessian;
    // An H that does not contain p_t has no metric.
    return inverse_metric[3][3] < 0 && is_form(at_rest, inverse_metric, rest) &&
           is_form(expand<4>(programs, q, moving), inverse_metric, moving);
}

/// The quadratic step from p = 0 comes first, so that forms quadratic in p have the root that compiled Hamiltonians
/// have; then both methods from guesses along d, from |p| = 1 outward to both sides; at last from where H = H0 on lines
/// along d, by turning. The first solution is taken.
Failure start_along(const Programs& programs, const double (&q)[3], const double (&d)[3], RayStart& out) {
    out = {{q[0], q[1], q[2]}, {0, 0, 0}, programs.pt, Failure::none, false, false};
    const double length = std::hypot(d[0], d[1], d[2]);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(q[i]) || !std::isfinite(d[i])) return out.failure = Failure::nonfinite_start;
    if (!(length > 0)) return out.failure = Failure::zero_direction;
    const Vector unit{d[0] / length, d[1] / length, d[2] / length};
    const auto solves = [&](Vector p, double mu) {
        if (!converge(programs, q, unit, p, mu)) return false;
        for (int i = 0; i < 3; ++i) out.p[i] = p[i];
        return true;
    };
    constexpr double guesses[] = {0, 1, 0.5, 2, 0.125, 8, 1.0 / 64, 64, 1e-4, 1e4};
    bool defined = false;
    for (const double guess : guesses) {
        const Vector start = moved({}, guess, unit);
        const Expansion<3> e = expand<3>(programs, q, start);
        if (!e.finite()) continue;
        defined = true;
        for (const bool quadratic : {true, false}) {
            Vector p = start;
            double mu = dot(e.gradient, unit);
            if (quadratic ? !quadratic_step(e, unit, p, mu) : !(mu > 0)) continue;
            if (solves(p, mu)) return Failure::none;
        }
    }
    for (const double side : {1.0, -1.0})
        for (const bool from_within : {false, true}) {
            const Vector c = from_within ? place_within(programs, q, side) : Vector{};
            if (from_within && size(c) == 0) continue;
            const double at = crossing(programs, q, c, unit, side);
            if (at == 0) continue;
            Vector p = moved(c, at, unit), from;
            slope(programs, q, p, from);
            double mu = size(from);
            for (double& component : from) component /= mu;
            if (turn_to(programs, q, from, unit, p, mu) && solves(p, mu)) return Failure::none;
        }
    return out.failure = defined ? Failure::no_momentum : Failure::singular_start;
}

}  // namespace kagero::formula
