#include "plan/units.h"

#include "modules/space.h"

#include <cmath>

namespace kagero {

namespace {

/// Range of the base-2 exponents of escape radii that need no conversion. Float represents the fourth powers of such
/// lengths, and the squares of quantities that are proportional to 1/length³.
constexpr int smallest_exponent = -10, largest_exponent = 20;

void divide(Double3& lengths, double unit) {
    for (double& x : lengths) x /= unit;
}

/// Converts the lengths of a space and of its integrator, except the step.
void convert_space(SpaceDescription& space, IntegratorDescription& integrator, const Module& module, double unit) {
    const HamiltonianInfo& info = module.hamiltonians[hamiltonian_index(module, space.hamiltonian)];
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        space.parameters[i].second *= std::pow(unit, -power_of_length(info.parameters[i].unit));
    divide(space.center, unit);
    integrator.escape_radius /= unit;
}

}  // namespace

double length_unit(const SceneDescription& scene) {
    const int exponent = std::ilogb(scene.integrator.escape_radius);
    if (smallest_exponent <= exponent && exponent <= largest_exponent) return 1;
    if (scene.space.formula || scene.integrator.rescaling) return 1;
    for (const MediumDescription& medium : scene.media)
        if (medium.space.formula || medium.integrator.rescaling) return 1;
    // A large scene may contain small details, so its unit is only as large as necessary.
    return std::scalbn(1.0, exponent < smallest_exponent ? exponent : exponent - largest_exponent);
}

void convert_lengths(SceneDescription& scene, const Module& module, double unit) {
    if (unit == 1) return;
    convert_space(scene.space, scene.integrator, module, unit);
    for (MediumDescription& medium : scene.media) convert_space(medium.space, medium.integrator, module, unit);
    divide(scene.camera.position, unit);
    divide(scene.camera.look_at, unit);
    scene.camera.height /= unit;
    scene.camera.aperture_radius /= unit;
    scene.camera.focus_distance /= unit;
    if (scene.space.sky_frame) scene.space.sky_frame->length_unit = unit;
    if (scene.camera.velocity) scene.camera.velocity->length_unit = unit;
    for (ObjectDescription& object : scene.objects) {
        for (Double3* lengths : {&object.origin, &object.edge_u, &object.edge_v, &object.min, &object.max,
                                 &object.center, &object.translate})
            divide(*lengths, unit);
        if (object.velocity) object.velocity->length_unit = unit;
        object.radius /= unit;
        object.inner /= unit;
        object.outer /= unit;
        object.scale /= unit;
    }
}

}  // namespace kagero
