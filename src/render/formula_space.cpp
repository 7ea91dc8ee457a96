#include "render/formula_space.h"

#include <cmath>

namespace kagero {
namespace {

/// |p| where it is the same, and along the ray, for all directions looked at; else 0.
double isotropic_momentum(const Plan& plan, ObserverKind kind) {
    constexpr Double3 directions[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}, {0, 0, 1},   {0, 0, -1},
                                      {1, 1, 1}, {-1, 2, 3}, {3, -1, 2}, {-2, -3, -1}, {2, 1, -3}, {-3, -1, 1}};
    constexpr double rounding = 1e-12;
    double size = 0;
    for (const Double3& d : directions) {
        const RayStart ray = formula_ray(plan, kind, plan.camera.position, d);
        if (ray.failure != Failure::none) return 0;
        const double length = std::hypot(d[0], d[1], d[2]);
        if (size == 0) size = std::hypot(ray.p[0], ray.p[1], ray.p[2]);
        for (std::size_t k = 0; k < 3; ++k)
            if (!(std::abs(ray.p[k] - size * d[k] / length) <= rounding * size)) return 0;
    }
    return size;
}

}  // namespace

std::vector<double> compile_formula(const FormulaDescription& description, const Module& module) {
    Formula formula = description.parsed;
    formula.nodes = description.scope.nodes.data();
    formula.node_count = static_cast<std::uint32_t>(description.scope.nodes.size());
    std::vector<double> programs(module.program_size);
    if (const char* why = module.compile(&formula, programs.data())) throw InputError(description.place, std::string("space.H: ") + why);
    return programs;
}

RayStart formula_ray(const Plan& plan, ObserverKind kind, const double (&q)[3], const Double3& d) {
    RayStart start{{q[0], q[1], q[2]}, {0, 0, 0}, 0, Failure::no_observer, false, false};
    if (kind == ObserverKind::zamo || kind == ObserverKind::falling) return start;
    plan.module->start(plan.job.hamiltonian, plan.parameters.data(), q, d.data(), &start);
    return start;
}

Failure place_formula_camera(Plan& plan) {
    CameraRays& camera = plan.camera;
    const ObserverKind kind = plan.view.observer;
    const RayStart middle = formula_ray(plan, kind, camera.position, plan.view.forward);
    camera.start = {};
    camera.start.offset[3] = middle.pt;
    const double size = isotropic_momentum(plan, kind);
    plan.each_direction = !(size > 0);
    if (plan.each_direction) return middle.failure;
    for (int i = 0; i < 3; ++i) camera.start.matrix[i][i] = size;
    return Failure::none;
}

}  // namespace kagero
