#include "plan/units.h"

#include <cmath>
#include <string_view>

namespace kagero {

namespace {

/// Scenes between these powers of two in size are left alone: float holds the fourth powers of such lengths, and the squares of what goes
/// with 1/length³.
constexpr int smallest = -10, largest = 20;

void divide(Double3& lengths, double unit) {
    for (double& x : lengths) x /= unit;
}

}  // namespace

std::optional<int> power_of_length(const ParameterInfo& parameter) {
    const std::string_view unit = parameter.unit;
    if (unit == "1" || unit == "whole number" || unit.empty()) return 0;
    if (unit == "scene lengths") return 1;
    if (unit == "1/length") return -1;
    if (unit == "1/length^2") return -2;
    if (unit == "1/length^3") return -3;
    return {};
}

double length_unit(const SceneDescription& scene, const HamiltonianInfo& info) {
    const int size = std::ilogb(scene.integrator.escape_radius);
    if ((smallest <= size && size <= largest) || scene.space.formula || scene.integrator.rescaling) return 1;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        if (!power_of_length(info.parameters[i])) return 1;
    // Of large scenes the inside may be small, and is made no smaller than need be.
    return std::scalbn(1.0, size < smallest ? size : size - largest);
}

void measure_in(SceneDescription& scene, const HamiltonianInfo& info, double unit) {
    if (unit == 1) return;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        scene.space.parameters[i].second *= std::pow(unit, -power_of_length(info.parameters[i]).value_or(0));
    divide(scene.space.center, unit);
    scene.integrator.escape_radius /= unit;
    divide(scene.camera.position, unit), divide(scene.camera.look_at, unit);
    scene.camera.height /= unit;
    for (ObjectDescription& object : scene.objects) {
        for (Double3* lengths :
             {&object.origin, &object.edge_u, &object.edge_v, &object.min, &object.max, &object.center, &object.translate})
            divide(*lengths, unit);
        object.radius /= unit, object.inner /= unit, object.outer /= unit, object.scale /= unit;
    }
}

}  // namespace kagero
