// Computes the momentum p at the start of a ray with the direction d, for any H: the solution of the two equations
// ∂H/∂p = μ d with μ > 0, and H = H0. Also computes the inverse metric of a formula that describes a spacetime.
#include "kernels/formula/interpreter.h"
#include "kernels/formula/programs.h"
#include "kernels/numeric/linear_solve.h"

#include <cmath>

namespace kagero::formula {
namespace {

using Vector = std::array<double, 3>;

double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const Vector& a) { return std::sqrt(dot(a, a)); }
/// Returns a + s·b.
Vector add_multiple(const Vector& a, double s, const Vector& b) {
    return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}
double distance(const Vector& a, const Vector& b) { return norm(add_multiple(a, -1, b)); }

/// H − H0 at (q, p), and the first and second derivatives of H with respect to the n = 3 components of p, or the n = 4
/// components of p and p_t.
template <std::size_t n>
struct Expansion {
    double value;
    std::array<double, n> gradient;
    Matrix<n> hessian;
    /// Returns true if all values are finite.
    bool finite() const {
        double sum = value;
        for (std::size_t i = 0; i < n; ++i) {
            sum += gradient[i];
            for (std::size_t k = 0; k < n; ++k) sum += hessian[i][k];
        }
        return std::isfinite(sum);
    }
};

/// Writes the parameters of the formula behind the state in the inputs of a program.
template <class Number>
void append_parameters(const Programs& programs, Number* in) {
    for (int i = 0; i < programs.parameters; ++i) in[state_size + i] = Number(programs.parameter[i]);
}

/// Returns the second-order expansion of H − H0 at (q, p).
template <std::size_t n>
Expansion<n> expand(const Programs& programs, const double (&q)[3], const std::array<double, n>& p) {
    using FirstOrder = Dual<double, n>;
    using SecondOrder = Dual<FirstOrder, n>;
    SecondOrder in[Code::max_inputs], out[1];
    append_parameters(programs, in);
    for (int i = 0; i < space_size; ++i) in[i] = SecondOrder(q[i]);
    in[component_pt] = SecondOrder(programs.pt);
    for (std::size_t a = 0; a < n; ++a)
        in[component_px + a] = SecondOrder::variable(FirstOrder::variable(p[a], int(a)), int(a));
    evaluate(programs.energy_residual, in, out);
    Expansion<n> e{out[0].value.value, out[0].value.derivative, {}};
    for (std::size_t a = 0; a < n; ++a) e.hessian[a] = out[0].derivative[a].derivative;
    return e;
}

/// Returns H − H0 and writes ∂H/∂p to `gradient`. This function is far cheaper than the second-order expansion.
double value_and_gradient(const Programs& programs, const double (&q)[3], const Vector& p, Vector& gradient) {
    using DualNumber = Dual<double, 3>;
    DualNumber in[Code::max_inputs], out[1];
    append_parameters(programs, in);
    for (int i = 0; i < space_size; ++i) {
        in[i] = DualNumber(q[i]);
        in[momentum(i)] = DualNumber::variable(p[i], i);
    }
    in[component_pt] = DualNumber(programs.pt);
    evaluate(programs.energy_residual, in, out);
    gradient = out[0].derivative;
    return out[0].value;
}

/// Solves both equations with the second-order expansion of H in place of H. The new p is p + G⁻¹(μ d − g), where g is
/// the gradient and G is the Hessian; H = H0 determines μ. If H is quadratic in p, the result is exact for every
/// initial p. Returns false if there is no real solution.
bool quadratic_step(const Expansion<3>& e, const Vector& d, Vector& p, double& mu) {
    std::array<Vector, 3> a = e.hessian, b = e.hessian;
    Vector inverse_d = d, inverse_g = e.gradient;
    solve_linear(3, a.data(), inverse_d.data());
    solve_linear(3, b.data(), inverse_g.data());  // G⁻¹ d, G⁻¹ g
    const double mu2 = 2 * (0.5 * dot(e.gradient, inverse_g) - e.value) / dot(d, inverse_d);
    if (!(mu2 > 0) || !std::isfinite(mu2)) return false;
    mu = std::sqrt(mu2);
    for (int i = 0; i < 3; ++i) p[i] += mu * inverse_d[i] - inverse_g[i];
    return std::isfinite(dot(p, p));
}

/// Performs one Newton step for the four unknowns p and μ: G δp − d δμ = μ d − g, g·δp = −(H − H0). The smallest normal
/// number is added to the diagonal of G, so that components of p that G does not determine stay unchanged.
void newton_step(const Expansion<3>& e, const Vector& d, Vector& p, double& mu) {
    std::array<std::array<double, 4>, 4> a{};
    std::array<double, 4> b{};
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) a[i][k] = e.hessian[i][k];
        a[i][i] += std::numeric_limits<double>::min();
        a[i][3] = -d[i];
        a[3][i] = e.gradient[i];
        b[i] = mu * d[i] - e.gradient[i];
    }
    b[3] = -e.value;
    solve_linear(4, a.data(), b.data());
    for (int i = 0; i < 3; ++i) p[i] += b[i];
    mu += b[3];
}

/// Returns the sum of the relative residuals of both equations at p. `value` is H − H0 and `gradient` is ∂H/∂p; d is a
/// unit vector. The result is infinite if μ ≤ 0.
double residual(double value, const Vector& gradient, const Vector& d, const Vector& p, double level) {
    const double mu = dot(gradient, d);
    if (!(mu > 0)) return std::numeric_limits<double>::infinity();
    Vector across;  // the part of ∂H/∂p that is perpendicular to d
    for (int i = 0; i < 3; ++i) across[i] = gradient[i] - mu * d[i];
    return norm(across) / mu + std::abs(value) / (std::abs(dot(p, gradient)) + std::abs(level));
}

/// Improves p by Newton's method until rounding prevents further progress; mu is the initial guess of μ. Returns false
/// if the iteration does not converge to a solution.
bool refine(const Programs& programs, const double (&q)[3], const Vector& d, Vector& p, double mu) {
    constexpr int max_iterations = 60;
    constexpr double tolerance = 1e-11, rounding = 1e-14;
    Vector gradient;
    const double value = value_and_gradient(programs, q, p, gradient);
    if (residual(value, gradient, d, p, programs.level) < rounding) return true;  // usual if H is quadratic in p
    double least = std::numeric_limits<double>::infinity();
    Vector best = p;
    for (int i = 0; i < max_iterations; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) break;
        const double current = residual(e.value, e.gradient, d, p, programs.level);
        if (current >= least && least < tolerance) break;
        if (current < least) {
            best = p;
            least = current;
        }
        if (current == 0) break;
        newton_step(e, d, p, mu);
    }
    p = best;
    return least < tolerance;
}

/// Searches the half-line from the point c of momentum space along d (side 1) or −d (side −1) for a sign change of
/// H − H0 from negative to positive in the direction of d. The search compares points whose distances from c are 1e-12
/// times powers of two, up to 1e12. Returns the signed distance of the first sign change from c along d; 0 if there is
/// none.
double find_level_crossing(const Programs& programs, const double (&q)[3], const Vector& c, const Vector& d,
                           double side) {
    constexpr double nearest = 1e-12, farthest = 1e12;
    const auto value = [&](double distance_from_c) {
        Vector unused;
        return side * value_and_gradient(programs, q, add_multiple(c, side * distance_from_c, d), unused);
    };
    double below = nearest, above = 2 * below;
    for (; above < farthest; below = above, above *= 2)
        if (value(below) < 0 && value(above) >= 0) break;
    if (!(above < farthest)) return 0;
    for (double middle; middle = 0.5 * (below + above), below < middle && middle < above;)
        (value(middle) < 0 ? below : above) = middle;
    return side * above;
}

/// Finds a point p inside the surface H = H0 of momentum space: a point with side·(H − H0) < 0, where side is ±1. If
/// the surface is convex, every line through the point crosses it. Newton's method starts from p = 0, approaches a
/// stationary point of H, and stops at the first point inside. Returns the zero vector if no point is found.
Vector find_inner_point(const Programs& programs, const double (&q)[3], double side) {
    constexpr int max_iterations = 100;
    Vector p{};
    for (int i = 0; i < max_iterations; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) break;
        if (side * e.value < 0) return p;
        std::array<Vector, 3> g = e.hessian;
        Vector step = e.gradient;
        for (int k = 0; k < 3; ++k) g[k][k] += std::numeric_limits<double>::min();
        solve_linear(3, g.data(), step.data());
        p = add_multiple(p, -1, step);
    }
    return {};
}

/// Solves both equations for p and μ by Newton's method, from a guess close to the solution. The iteration ends when
/// its steps no longer shrink: in directions in which H is nearly constant, p converges later than the residual.
/// Returns false if there is no convergence, or if p moves by more than half of its initial length.
bool solve_momentum(const Programs& programs, const double (&q)[3], const Vector& d, Vector& p, double& mu) {
    constexpr int max_iterations = 16;
    constexpr double tolerance = 1e-8, rounding = 1e-13, max_distance = 0.5, convergence_factor = 0.5;
    const Vector initial_p = p;
    double previous_step = std::numeric_limits<double>::infinity();
    for (int i = 0; i < max_iterations; ++i) {
        const Expansion<3> e = expand<3>(programs, q, p);
        if (!e.finite()) return false;
        const bool small_residual = residual(e.value, e.gradient, d, p, programs.level) < tolerance;
        Vector next = p;
        double next_mu = mu;
        newton_step(e, d, next, next_mu);
        const double step = distance(next, p);
        if (small_residual && (step <= rounding * norm(p) || step >= convergence_factor * previous_step)) return true;
        p = next;
        mu = next_mu;
        previous_step = step;
        if (!(distance(p, initial_p) <= max_distance * norm(initial_p))) return false;
    }
    return false;
}

/// Solves both equations for the direction d by continuation, from a solution p, μ for the direction `initial_d`. The
/// direction turns in small steps, and each solution is the guess for the next direction. This also works if no guess
/// along d is close to the solution, for example if H contains higher powers of p than the second. Returns false if the
/// continuation stops before d.
bool continue_to(const Programs& programs, const double (&q)[3], const Vector& initial_d, const Vector& d, Vector& p,
                 double& mu) {
    constexpr int max_steps = 100;
    double completed = 0, step = 1;  // fractions of the way from initial_d to d
    for (int n = 0; n < max_steps && completed < 1 && completed + step > completed; ++n) {
        const double fraction = std::min(1.0, completed + step);
        Vector target;
        for (int i = 0; i < 3; ++i) target[i] = (1 - fraction) * initial_d[i] + fraction * d[i];
        const double length = norm(target);
        for (double& component : target) component /= length;
        Vector tried = p;
        double tried_mu = mu;
        if (solve_momentum(programs, q, target, tried, tried_mu)) {
            p = tried;
            mu = tried_mu;
            completed = fraction;
            step *= 4;
        } else step *= 0.125;
    }
    return completed >= 1;
}

/// Returns true if the expansion e at p is that of ½ g^{ab} p_a p_b.
bool is_quadratic_form(const Expansion<4>& e, const Matrix<4>& g, const std::array<double, 4>& p) {
    constexpr double rounding = 1e-12;
    double value = 0, greatest = 0, deviation = 0;
    for (int a = 0; a < 4; ++a) {
        double slope = 0, terms = 0;
        for (int b = 0; b < 4; ++b) {
            slope += g[a][b] * p[b];
            terms += std::abs(g[a][b] * p[b]);
            deviation = std::max(deviation, std::abs(e.hessian[a][b] - g[a][b]));
            greatest = std::max(greatest, std::abs(g[a][b]));
        }
        value += 0.5 * p[a] * slope;
        if (!(std::abs(e.gradient[a] - slope) <= rounding * (terms + greatest))) return false;
    }
    return deviation <= rounding * greatest && std::abs(e.value - value) <= rounding * greatest;
}

}  // namespace

bool inverse_metric_of(const Programs& programs, const double (&q)[3], Matrix<4>& inverse_metric) {
    if (programs.level != 0 || programs.pt == 0) return false;
    // H is compared with the quadratic form at two points.
    const std::array<double, 4> p_first{0, 0, 0, 1}, p_second{0.6, -0.3, 0.7, 0.8};
    const Expansion<4> first = expand<4>(programs, q, p_first);
    inverse_metric = first.hessian;
    if (!is_quadratic_form(first, inverse_metric, p_first) ||
        !is_quadratic_form(expand<4>(programs, q, p_second), inverse_metric, p_second))
        return false;
    // Light that is followed backward in time has p_t < 0 if H has the signature +−−−.
    const double sign = programs.pt > 0 ? 1 : -1;
    for (auto& row : inverse_metric)
        for (double& entry : row) entry *= sign;
    // g^{tt} is 0 if H does not contain p_t; H then has no metric.
    return inverse_metric[3][3] < 0;
}

/// Tries several methods in turn and returns the first solution. First come a quadratic step and Newton's method from
/// p = 0: for H quadratic in p, the result is the same solution as for compiled Hamiltonians. The next guesses are s d
/// with s = 1, ½, 2 and further values of s in order of their distance from 1. Finally, continuation starts from points
/// on lines along d where H = H0.
Failure start_along(const Programs& programs, const double (&q)[3], const double (&d)[3], RayStart& out) {
    out = {{q[0], q[1], q[2]}, {0, 0, 0}, programs.pt, Failure::none, false, false};
    const double length = std::hypot(d[0], d[1], d[2]);
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(q[i]) || !std::isfinite(d[i])) return out.failure = Failure::nonfinite_start;
    if (!(length > 0)) return out.failure = Failure::zero_direction;
    const Vector unit{d[0] / length, d[1] / length, d[2] / length};
    const auto solves = [&](Vector p, double mu) {
        if (!refine(programs, q, unit, p, mu)) return false;
        for (int i = 0; i < 3; ++i) out.p[i] = p[i];
        return true;
    };
    constexpr double guesses[] = {0, 1, 0.5, 2, 0.125, 8, 1.0 / 64, 64, 1e-4, 1e4};
    bool defined = false;  // H and its derivatives are finite for a guess
    for (const double guess : guesses) {
        const Vector start = add_multiple({}, guess, unit);
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
        for (const bool from_inside : {false, true}) {
            const Vector c = from_inside ? find_inner_point(programs, q, side) : Vector{};
            if (from_inside && norm(c) == 0) continue;
            const double offset = find_level_crossing(programs, q, c, unit, side);
            if (offset == 0) continue;
            Vector p = add_multiple(c, offset, unit), initial_d;
            value_and_gradient(programs, q, p, initial_d);
            double mu = norm(initial_d);
            for (double& component : initial_d) component /= mu;
            if (continue_to(programs, q, initial_d, unit, p, mu) && solves(p, mu)) return Failure::none;
        }
    return out.failure = defined ? Failure::no_momentum : Failure::singular_start;
}

}  // namespace kagero::formula
