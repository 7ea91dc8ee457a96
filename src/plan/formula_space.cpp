#include "plan/formula_space.h"

#include "rays/camera.h"
#include "scene/vector3.h"

#include <cmath>

namespace kagero {
namespace {

/// H at p in a place.
double energy(const FormulaDescription& formula, const double (&q)[3], const Double3& p) {
    return evaluate(formula.scope, formula.parsed.energy, {q[0], q[1], q[2], p[0], p[1], p[2], formula.parsed.pt});
}

/// The map of an H quadratic in p, H = ½ p·G p + g·p + c: from ∂H/∂p = G p + g = μ d follows p = μ G⁻¹ d − G⁻¹ g, and from H = H0
/// μ² d·G⁻¹ d = 2 (H0 − c) + g·G⁻¹ g. Of any other H it is nonsense.
StartMap quadratic_map(const FormulaDescription& formula, const double (&q)[3], double pt) {
    const auto h = [&](const Double3& p) { return energy(formula, q, p); };
    constexpr Double3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double c = h({0, 0, 0});
    Double3 slope{}, bend[3];
    for (std::size_t i = 0; i < 3; ++i) slope[i] = 0.5 * (h(axes[i]) - h(scaled(axes[i], -1)));
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
            bend[i][k] = i == k ? h(axes[i]) + h(scaled(axes[i], -1)) - 2 * c : h(add(axes[i], axes[k])) - h(axes[i]) - h(axes[k]) + c;
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

std::vector<double> compiled(Formula formula, const FormulaScope& scope, const Module& module, const Place& place, const std::string& name) {
    formula.nodes = scope.nodes.data();
    formula.node_count = static_cast<std::uint32_t>(scope.nodes.size());
    std::vector<double> programs(module.program_size);
    if (const char* why = module.compile(&formula, programs.data())) throw InputError(place, name + ": " + why);
    return programs;
}

/// Whether the map gives the momenta that solving for them gives, in all directions looked at.
bool serves(const StartMap& map, const Plan& plan) {
    constexpr Double3 directions[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}, {0, 0, 1},   {0, 0, -1},
                                      {1, 1, 1}, {-1, 2, 3}, {3, -1, 2}, {-2, -3, -1}, {2, 1, -3}, {-3, -1, 1}};
    constexpr double rounding = 1e-12;
    for (const Double3& d : directions) {
        const RayStart ray = formula_ray(plan, plan.camera.position, d);
        if (ray.failure != Failure::none) return false;
        const RayStart mapped = ray_in_frame(map, plan.camera.position, d).start;
        const Double3 p{ray.p[0], ray.p[1], ray.p[2]}, other{mapped.p[0], mapped.p[1], mapped.p[2]};
        if (!(length(subtract(p, other)) <= rounding * length(p))) return false;
    }
    return true;
}

}  // namespace

std::vector<double> compile_formula(const FormulaDescription& description, const Module& module) {
    return compiled(description.parsed, description.scope, module, description.place, "space.H");
}

std::vector<double> compile_rescaled(const RescalingDescription& rescaling, const Plan& plan) {
    Formula formula{nullptr, 0, -1, -1, -1, -1, rescaling.node, {-1, -1}, plan.module->hamiltonians[plan.hamiltonian].level, 0};
    formula.hamiltonian = plan.hamiltonian, formula.parameters = plan.parameters.data();
    return compiled(formula, rescaling.scope, *plan.module, *plan.scene.integrator.rescale_place, "integrator.rescale");
}

RayStart formula_ray(const Plan& plan, const double (&q)[3], const Double3& d) {
    RayStart start;
    plan.module->start(plan.hamiltonian, plan.parameters.data(), q, d.data(), &start);
    return start;
}

Failure place_formula_camera(Plan& plan, StartMap& map) {
    const RayStart middle = formula_ray(plan, plan.camera.position, plan.view.forward);
    map = quadratic_map(*plan.scene.space.formula, plan.camera.position, middle.pt);
    plan.each_direction = !serves(map, plan);
    if (plan.each_direction) return middle.failure;
    return Failure::none;
}

}  // namespace kagero
