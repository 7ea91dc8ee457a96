#include "spaces/formula_space.h"

#include "formula/nodes.h"
#include "kernels/operation.h"
#include "scene/vector3.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Returns H(q, p).
double value_of_h(const FormulaDescription& formula, const double (&q)[3], const Double3& p) {
    return evaluate(formula.scope, formula.parsed.energy, {q[0], q[1], q[2], p[0], p[1], p[2], formula.parsed.pt});
}

/// Compiles a formula whose nodes are in `scope`. If the module refuses it, throws InputError with the file position
/// `location` of the scene key `key`.
std::vector<double> compile_nodes(Formula formula, const FormulaScope& scope, const Module& module,
                                  const FileLocation& location, const std::string& key) {
    formula.nodes = scope.nodes.data();
    formula.node_count = static_cast<std::uint32_t>(scope.nodes.size());
    std::vector<double> programs(module.program_size);
    if (const char* reason = module.compile(&formula, programs.data())) throw InputError(location, key + ": " + reason);
    return programs;
}

/// Returns a formula that states nothing, so that everything is that of a built-in space.
Formula formula_of_space(const Space& space) {
    return {.nodes = nullptr,
            .node_count = 0,
            .energy = -1,
            .domain = -1,
            .capture = -1,
            .length_scale = -1,
            .rescale = -1,
            .parts = {-1, -1},
            .level = space.info().level,
            .pt = 0,
            .hamiltonian = space.hamiltonian,
            .parameters = space.parameters.data()};
}

/// Returns Formula::branch_magnitudes: medians at some points whose distance from the origin is at most `size`.
std::vector<double> branch_magnitudes(const FormulaDescription& formula, double size) {
    constexpr int points = 48;
    std::vector<double> magnitudes(formula.scope.nodes.size(), 1);
    for (std::size_t i = 0; i < magnitudes.size(); ++i) {
        const FormulaNode& node = formula.scope.nodes[i];
        if (!has_branches(node.op)) continue;
        std::vector<double> values;
        for (int k = 0; k < points; ++k) {
            // The directions are spread evenly over the sphere, and the distances over two orders of magnitude.
            const double height = 2 * (k + 0.5) / points - 1, width = std::sqrt(1 - height * height),
                         angle = 2.39996 * k, distance = size * std::pow(0.01, double((7 * k) % points) / points);
            const FormulaPoint point{distance * width * std::cos(angle),
                                     distance * width * std::sin(angle),
                                     distance * height,
                                     1,
                                     0.5,
                                     0.25,
                                     formula.parsed.pt};
            const double other = branches_by_sign(node.op) ? 0 : evaluate(formula.scope, node.b, point);
            const double difference = std::abs(evaluate(formula.scope, node.a, point) - other);
            if (difference > 0 && std::isfinite(difference)) values.push_back(difference);
        }
        if (values.empty()) continue;
        const auto median = values.begin() + std::ptrdiff_t(values.size() / 2);
        std::nth_element(values.begin(), median, values.end());
        magnitudes[i] = *median;
    }
    return magnitudes;
}

}  // namespace

std::vector<double> compile_formula(const FormulaDescription& description, const Module& module, double size,
                                    bool for_comparison) {
    const std::vector<double> magnitudes = branch_magnitudes(description, size);
    Formula formula = description.parsed;
    formula.branch_magnitudes = magnitudes.data();
    formula.for_comparison = for_comparison;
    return compile_nodes(formula, description.scope, module, description.location, description.table + ".H");
}

void set_parameters(FormulaDescription& formula, const double* values, Space& space) {
    for (FormulaNode& node : formula.scope.nodes)
        if (node.op == Op::parameter) node.value = values[node.a];
    space.module->formula_functions.set_parameters(space.parameters.data(), values);
}

bool has_kinks(const FormulaDescription& formula) {
    std::vector<bool> needed(formula.scope.nodes.size());
    needed[std::size_t(formula.parsed.energy)] = true;
    for (std::int32_t i = formula.parsed.energy; i >= 0; --i) {
        const FormulaNode& node = formula.scope.nodes[std::size_t(i)];
        if (!needed[std::size_t(i)] || is_leaf(node.op)) continue;
        if (has_branches(node.op)) return true;
        needed[std::size_t(node.a)] = true;
        if (node.b >= 0) needed[std::size_t(node.b)] = true;
    }
    return false;
}

std::vector<double> compile_rescaled(const IntegratorDescription& integrator, const Space& space, bool for_comparison) {
    const RescalingDescription& rescaling = *integrator.rescaling;
    Formula formula = formula_of_space(space);
    formula.rescale = rescaling.node;
    formula.for_comparison = for_comparison;
    return compile_nodes(formula, rescaling.scope, *space.module, *integrator.rescale_location, "integrator.rescale");
}

std::vector<double> record_space(const Space& space, bool rescaled) {
    Formula formula = formula_of_space(space);
    formula.declared_rescaling = rescaled;
    formula.for_comparison = true;
    return compile_nodes(formula, {}, *space.module, {}, "the programs of space.hamiltonian");
}

double speed_of(const FormulaDescription& formula, const RayStart& ray) {
    const Double3 p{ray.p[0], ray.p[1], ray.p[2]};
    const double difference = 1e-6 * length(p);
    Double3 velocity{};
    for (std::size_t i = 0; i < 3; ++i) {
        Double3 after = p, before = p;
        after[i] += difference;
        before[i] -= difference;
        velocity[i] = (value_of_h(formula, ray.q, after) - value_of_h(formula, ray.q, before)) / (2 * difference);
    }
    return length(velocity);
}

std::optional<Jump> jump_at(const FormulaDescription& formula, const RayEnd& end) {
    constexpr double least_distance = 1e-13, greatest_distance = 1e-6;  // relative to |q|
    const Double3 q{end.q[0], end.q[1], end.q[2]}, p{end.p[0], end.p[1], end.p[2]}, v{end.v[0], end.v[1], end.v[2]};
    const auto value_at = [&](double distance) {
        const Double3 x = add(q, scaled(v, distance));
        return value_of_h(formula, {x[0], x[1], x[2]}, p);
    };
    const double size = std::max(length(q), std::numeric_limits<double>::min()),
                 before = value_at(-greatest_distance * size);
    for (double distance = least_distance; distance < 2 * greatest_distance; distance *= 10) {
        const double behind = value_at(distance * size), farther = value_at((distance + greatest_distance) * size);
        // A continuous change over this distance is smaller than a jump.
        if (std::abs(behind - before) > 10 * std::abs(farther - behind)) return Jump{value_at(0), behind};
    }
    return std::nullopt;
}

StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt) {
    const auto h = [&](const Double3& p) { return value_of_h(formula, q, p); };
    constexpr Double3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double c = h({0, 0, 0});
    // g is the gradient and G the Hessian of H at p = 0. These differences are exact for a quadratic function.
    Double3 gradient{}, hessian[3];
    for (std::size_t i = 0; i < 3; ++i) gradient[i] = 0.5 * (h(axes[i]) - h(scaled(axes[i], -1)));
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            hessian[i][k] = i == k ? h(axes[i]) + h(scaled(axes[i], -1)) - 2 * c
                                   : h(add(axes[i], axes[k])) - h(axes[i]) - h(axes[k]) + c;
    // Columns of the adjugate det(G) G⁻¹ of the symmetric matrix G.
    const Double3 adjugate[] = {cross(hessian[1], hessian[2]), cross(hessian[2], hessian[0]),
                                cross(hessian[0], hessian[1])};
    const double determinant = dot(hessian[0], adjugate[0]);
    StartMap map{};
    std::copy(q, q + 3, map.position);
    // G⁻¹ g
    const Double3 offset{dot(gradient, {adjugate[0][0], adjugate[1][0], adjugate[2][0]}) / determinant,
                         dot(gradient, {adjugate[0][1], adjugate[1][1], adjugate[2][1]}) / determinant,
                         dot(gradient, {adjugate[0][2], adjugate[1][2], adjugate[2][2]}) / determinant};
    const double mu = std::sqrt(2 * (formula.level - c) + dot(gradient, offset));
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            map.metric[i][k] = adjugate[k][i] / determinant;
            map.matrix[i][k] = mu * map.metric[i][k];
        }
        map.offset[i] = -offset[i];
    }
    map.offset[3] = pt;
    return map;
}

}  // namespace kagero
