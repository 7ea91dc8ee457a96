#include "plan/formula_space.h"

#include "formula/nodes.h"
#include "scene/vector3.h"

#include <cmath>

namespace kagero {
namespace {

/// H at p in a place.
double energy(const FormulaDescription& formula, const double (&q)[3], const Double3& p) {
    return evaluate(formula.scope, formula.parsed.energy, {q[0], q[1], q[2], p[0], p[1], p[2], formula.parsed.pt});
}

std::vector<double> compiled(Formula formula, const FormulaScope& scope, const Module& module, const Place& place,
                             const std::string& name) {
    formula.nodes = scope.nodes.data();
    formula.node_count = static_cast<std::uint32_t>(scope.nodes.size());
    std::vector<double> programs(module.program_size);
    if (const char* why = module.compile(&formula, programs.data())) throw InputError(place, name + ": " + why);
    return programs;
}

}  // namespace

std::vector<double> compile_formula(const FormulaDescription& description, const Module& module) {
    return compiled(description.parsed, description.scope, module, description.place, "space.H");
}

std::vector<double> compile_rescaled(const IntegratorDescription& integrator, const Space& space) {
    const RescalingDescription& rescaling = *integrator.rescaling;
    Formula formula{nullptr, 0, -1, -1, -1, -1, rescaling.node, {-1, -1}, space.info().level, 0};
    formula.hamiltonian = space.hamiltonian, formula.parameters = space.parameters.data();
    return compiled(formula, rescaling.scope, *space.module, *integrator.rescale_place, "integrator.rescale");
}

StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt) {
    const auto h = [&](const Double3& p) { return energy(formula, q, p); };
    constexpr Double3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double c = h({0, 0, 0});
    Double3 slope{}, bend[3];
    for (std::size_t i = 0; i < 3; ++i) slope[i] = 0.5 * (h(axes[i]) - h(scaled(axes[i], -1)));
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            bend[i][k] = i == k ? h(axes[i]) + h(scaled(axes[i], -1)) - 2 * c
                                : h(add(axes[i], axes[k])) - h(axes[i]) - h(axes[k]) + c;
    const Double3 columns[] = {cross(bend[1], bend[2]), cross(bend[2], bend[0]), cross(bend[0], bend[1])};
    const double determinant = dot(bend[0], columns[0]);
    StartMap map{};
    const Double3 back{dot(slope, {columns[0][0], columns[1][0], columns[2][0]}) / determinant,
                       dot(slope, {columns[0][1], columns[1][1], columns[2][1]}) / determinant,
                       dot(slope, {columns[0][2], columns[1][2], columns[2][2]}) / determinant};
    const double mu = std::sqrt(2 * (formula.level - c) + dot(slope, back));
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            map.metric[i][k] = columns[k][i] / determinant;
            map.matrix[i][k] = mu * map.metric[i][k];
        }
        map.offset[i] = -back[i];
    }
    map.offset[3] = pt;
    return map;
}

}  // namespace kagero
