#include "spaces/rest_frame.h"

#include "formula/nodes.h"
#include "kernels/operation.h"
#include "scene/value.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

namespace kagero {
namespace {

/// Returns h^(−1/2) of a symmetric positive definite matrix, by the iteration of Denman and Beavers (1976).
std::array<Double3, 3> inverse_square_root(std::array<Double3, 3> h) {
    constexpr int steps = 40;
    const auto inverse_of = [](const std::array<Double3, 3>& m) {
        const std::array<Double3, 3> adjugate{cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])};
        const double determinant = dot(m[0], adjugate[0]);
        std::array<Double3, 3> result;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) result[i][k] = adjugate[k][i] / determinant;
        return result;
    };
    const double scale = (h[0][0] + h[1][1] + h[2][2]) / 3;  // the iteration converges fast for eigenvalues near 1
    std::array<Double3, 3> z{Double3{1, 0, 0}, Double3{0, 1, 0}, Double3{0, 0, 1}};
    for (Double3& row : h) row = scaled(row, 1 / scale);
    for (int step = 0; step < steps; ++step) {
        const std::array<Double3, 3> inverse_h = inverse_of(h), inverse_z = inverse_of(z);
        double change = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k) {
                const double next = 0.5 * (z[i][k] + inverse_h[i][k]);
                h[i][k] = 0.5 * (h[i][k] + inverse_z[i][k]);
                change = std::max(change, std::abs(next - z[i][k]));
                z[i][k] = next;
            }
        if (!(change > std::numeric_limits<double>::epsilon() * std::abs(z[0][0]))) break;
    }
    for (Double3& row : z) row = scaled(row, 1 / std::sqrt(scale));
    return z;
}

/// Inverts a matrix by Gauss–Jordan elimination with partial pivoting. The result is not finite if it is singular.
SpacetimeMatrix inverse_of(SpacetimeMatrix m) {
    SpacetimeMatrix result{};
    for (std::size_t i = 0; i < 4; ++i) result[i][i] = 1;
    for (std::size_t column = 0; column < 4; ++column) {
        std::size_t pivot = column;
        for (std::size_t i = column + 1; i < 4; ++i)
            if (std::abs(m[i][column]) > std::abs(m[pivot][column])) pivot = i;
        std::swap(m[column], m[pivot]);
        std::swap(result[column], result[pivot]);
        const double scale = 1 / m[column][column];
        for (std::size_t k = 0; k < 4; ++k) {
            m[column][k] *= scale;
            result[column][k] *= scale;
        }
        for (std::size_t i = 0; i < 4; ++i) {
            const double factor = i == column ? 0 : m[i][column];
            for (std::size_t k = 0; k < 4; ++k) {
                m[i][k] -= factor * m[column][k];
                result[i][k] -= factor * result[column][k];
            }
        }
    }
    return result;
}

/// Test momenta (p_x, p_y, p_z, p_t): 1 in the components a and b, and 0 in the others.
struct TestMomentum {
    std::size_t a, b;
};
constexpr std::array<TestMomentum, 10> test_momenta{
    {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {1, 0}, {2, 0}, {2, 1}, {3, 0}, {3, 1}, {3, 2}}};
using MomentumValues = std::array<double, test_momenta.size()>;

/// Returns the values of H at q for the test momenta. Parts of H that do not depend on the momentum are evaluated once.
MomentumValues values_of_h(const FormulaDescription& formula, const double (&q)[3]) {
    constexpr unsigned momentum_variables = 0b1111000;  // bits of FormulaScope::variables
    const FormulaScope& scope = formula.scope;
    const auto root = static_cast<std::size_t>(formula.parsed.energy);
    std::vector<char> needed(root + 1);
    needed[root] = 1;
    for (std::size_t i = root; i > 0; --i) {
        const FormulaNode& node = scope.nodes[i];
        if (!needed[i] || is_leaf(node.op)) continue;
        needed[static_cast<std::size_t>(node.a)] = 1;
        if (node.b >= 0) needed[static_cast<std::size_t>(node.b)] = 1;
    }
    std::vector<MomentumValues> values(root + 1);  // only the first value where there is no momentum
    const auto varies = [&](std::size_t i) { return (scope.variables[i] & momentum_variables) != 0; };
    for (std::size_t i = 0; i <= root; ++i) {
        if (!needed[i]) continue;
        const FormulaNode& node = scope.nodes[i];
        const auto a = static_cast<std::size_t>(node.a), b = static_cast<std::size_t>(node.b);
        for (std::size_t k = 0; k < (varies(i) ? test_momenta.size() : 1); ++k) {
            if (node.op == Op::constant || node.op == Op::parameter) values[i][k] = node.value;
            else if (node.op == Op::input)
                values[i][k] = a < 3 ? q[a] : double(test_momenta[k].a == a - 3 || test_momenta[k].b == a - 3);
            else {
                const double second = node.b < 0 ? 0 : values[b][varies(b) ? k : 0];
                values[i][k] = apply(node.op, values[a][varies(a) ? k : 0], second);
            }
        }
    }
    MomentumValues h = values[root];
    if (!varies(root)) h.fill(h[0]);
    return h;
}

/// Returns the signs by which the components x, y, z, t of a covector are multiplied between the ingoing coordinates
/// inside the horizon and the kernel's state.
std::array<double, 4> reflection_signs(const Space& space) {
    return {1, space.hole().spin != 0 ? -1.0 : 1.0, 1, -1};
}

/// Replaces the columns of a map in outgoing coordinates by those of the kernel's state in ingoing coordinates.
void convert_to_ingoing(const Space& space, StartMap& map) {
    const Hole hole = space.hole();
    const StartMap outgoing = map;
    for (int j = 0; j < 4; ++j) {
        const auto entry = [j](auto& m, int i) -> auto& { return j < 3 ? m.matrix[i][j] : m.offset[i]; };
        RayStart state{};
        std::copy_n(outgoing.position, 3, state.q);
        for (int i = 0; i < 3; ++i) state.p[i] = entry(outgoing, i);
        state.pt = entry(outgoing, 3);
        space.module->to_ingoing(&hole, &state);
        for (int i = 0; i < 3; ++i) entry(map, i) = state.p[i];
        entry(map, 3) = state.pt;
        std::copy_n(state.q, 3, map.position);
    }
    map.ingoing = true;
}

/// Replaces a map in ingoing coordinates inside the horizon by that of the kernel's state.
void reflect_inside(const Space& space, StartMap& map) {
    const std::array<double, 4> sign = reflection_signs(space);
    for (std::size_t a = 0; a < 4; ++a) {
        for (double& entry : map.matrix[a]) entry *= sign[a];
        map.offset[a] *= sign[a];
    }
    map.position[1] *= sign[1];
    map.ingoing = true;
}

}  // namespace

// The rest frame of the observer at rest in the coordinates consists of orthonormal covectors. The metric is the sum of
// their squares, with a negative sign for the 4-velocity.
Failure metric_at(const Space& space, const double (&q)[3], SpacetimeMatrix& g, double* momentum_sign) {
    // The kernels examine formulas themselves.
    const bool may_be_spacetime = space.info().spacetime || std::string_view(space.info().name) == "formula";
    if (!may_be_spacetime) return Failure::no_rest_frame;
    const bool inside = is_inside_horizon(space, q);
    const std::array<double, 4> sign = inside ? reflection_signs(space) : std::array<double, 4>{1, 1, 1, 1};
    StartMap frame{};
    const Failure failure =
        space.observe(ObserverKind::coordinate, {q[0], sign[1] * q[1], q[2]}, false, frame);
    if (failure != Failure::none) return failure;
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
            const double* const x = frame.matrix[a];
            const double* const y = frame.matrix[b];
            const double entry = x[0] * y[0] + x[1] * y[1] + x[2] * y[2] - frame.offset[a] * frame.offset[b];
            g[a][b] = sign[a] * sign[b] * entry;
            sum += entry;
        }
    // The covariant 4-velocity of this observer is u_a ∝ −∂t/∂x^a, and the offset is −u_a.
    if (momentum_sign) *momentum_sign = frame.offset[3] < 0 ? -1 : 1;
    return std::isfinite(sum) ? Failure::none : Failure::singular_start;
}

// H is quadratic in the momenta. Its values at the unit vectors and at their sums therefore determine g^{ab}.
bool metric_of_formula(const FormulaDescription& formula, const double (&q)[3], SpacetimeMatrix& g) {
    const MomentumValues h = values_of_h(formula, q);
    SpacetimeMatrix inverse_metric;
    for (std::size_t a = 0; a < 4; ++a) inverse_metric[a][a] = 2 * h[a];
    for (std::size_t i = 4; i < test_momenta.size(); ++i) {
        const auto [a, b] = test_momenta[i];
        inverse_metric[a][b] = inverse_metric[b][a] = h[i] - (h[a] + h[b]);
    }
    g = inverse_of(inverse_metric);
    const double sign = formula.parsed.pt < 0 ? -1 : 1;  // H has the signature +−−− if light runs backward with p_t < 0
    double sum = 0;
    for (auto& row : g)
        for (double& entry : row) sum += entry *= sign;
    return std::isfinite(sum);
}

double product(const SpacetimeMatrix& g, const std::array<double, 4>& v, const std::array<double, 4>& w) {
    double sum = 0;
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) sum += v[a] * g[a][b] * w[b];
    return sum;
}

std::optional<RestFrame> rest_frame(const SpacetimeMatrix& g, const Double3& v) {
    constexpr double rounding = 64 * std::numeric_limits<double>::epsilon();
    const std::array<double, 4> w{v[0], v[1], v[2], 1};
    double square = 0, sum_of_magnitudes = 0;
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
            square += w[a] * g[a][b] * w[b];
            sum_of_magnitudes += std::abs(w[a] * g[a][b] * w[b]);
        }
    if (!(square < -rounding * sum_of_magnitudes) || !std::isfinite(square)) return std::nullopt;
    RestFrame frame{};
    const double time_rate = 1 / std::sqrt(-square);  // u^t
    for (std::size_t a = 0; a < 4; ++a) frame.u[a] = time_rate * w[a];
    for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) frame.covariant_u[a] += g[a][b] * frame.u[b];
    std::array<Double3, 3> h;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) h[i][k] = g[i][k] + frame.covariant_u[i] * frame.covariant_u[k];
    frame.inverse_root = inverse_square_root(h);
    return frame;
}

ObservedLight observed_light(const RestFrame& frame, const double (&p)[3], double pt) {
    const std::array<double, 4>& u = frame.u;
    const double sign = frame.momentum_sign,
                 frequency = sign * (p[0] * u[0] + p[1] * u[1] + p[2] * u[2] + pt * u[3]);
    Double3 along_axes;  // p · e_k
    for (std::size_t k = 0; k < 3; ++k) along_axes[k] = sign * p[k] + frequency * frame.covariant_u[k];
    Double3 direction;
    for (std::size_t i = 0; i < 3; ++i) direction[i] = dot(frame.inverse_root[i], along_axes);
    return {frequency, unit(direction)};
}

Failure make_moving_map(const Space& space, const double (&q)[3], const Double3& v, bool ingoing, StartMap& map) {
    map = {};
    std::copy(q, q + 3, map.position);
    SpacetimeMatrix g;
    double sign;
    if (const Failure failure = metric_at(space, q, g, &sign); failure != Failure::none) return failure;
    const auto frame = rest_frame(g, v);
    if (!frame) return Failure::no_observer;
    const std::array<double, 4>& u = frame->covariant_u;
    for (std::size_t a = 0; a < 4; ++a) {
        map.offset[a] = -sign * u[a];
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t k = 0; k < 3; ++k)
                map.matrix[a][i] += sign * frame->inverse_root[i][k] * (g[k][a] + u[k] * u[a]);
    }
    if (is_inside_horizon(space, q)) reflect_inside(space, map);
    else if (ingoing) convert_to_ingoing(space, map);
    return Failure::none;
}

std::array<Double3, 3> axes_in_coordinates(const SpacetimeMatrix& g, double momentum_sign, const StartMap& map) {
    const SpacetimeMatrix inverse_metric = inverse_of(g);
    std::array<Double3, 3> axes{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t b = 0; b < 4; ++b) axes[i][k] += momentum_sign * inverse_metric[k][b] * map.matrix[b][i];
    return axes;
}

std::string speed_limit(const SpacetimeMatrix& g, const Double3& v) {
    if (!std::isfinite(length(v))) return "each component must be a finite number";
    if (length(v) == 0) return "nothing can be at rest here; state another velocity";
    const Double3 n = unit(v);
    const std::array<double, 4> along{n[0], n[1], n[2], 0}, time{0, 0, 0, 1};
    // The vector with the speed s is timelike if a + 2bs + cs² < 0.
    const double a = product(g, time, time), b = product(g, time, along), c = product(g, along, along),
                 discriminant = b * b - a * c;
    if (!(c > 0) || !(discriminant > 0)) return "no speed in this direction is below the speed of light";
    const double least = (-b - std::sqrt(discriminant)) / c, greatest = (-b + std::sqrt(discriminant)) / c;
    if (greatest <= 0) return "no speed in this direction is below the speed of light";
    if (least <= 0) return "in this direction, the speed |dq/dt| must be less than " + to_toml(greatest);
    return "in this direction, the speed |dq/dt| must be between " + to_toml(least) + " and " + to_toml(greatest);
}

}  // namespace kagero
