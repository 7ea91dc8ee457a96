#include "plan/units.h"

#include <cmath>

namespace kagero {

namespace {

/// Range of the base-2 exponents of escape radii that need no conversion. Float represents the fourth powers of such
/// lengths, and the squares of quantities that are proportional to 1/length³.
constexpr int smallest_exponent = -10, largest_exponent = 20;

void divide(Double3& lengths, double unit) {
    for (double& x : lengths) x /= unit;
}

}  // namespace

double length_unit(const SceneDescription& scene) {
    const int exponent = std::ilogb(scene.integrator.escape_radius);
    if (smallest_exponent <= exponent && exponent <= largest_exponent) return 1;
    if (scene.space.formula || scene.integrator.rescaling) return 1;
    // A large scene may contain small details, so its unit is only as large as necessary.
    return std::scalbn(1.0, exponent < smallest_exponent ? exponent : exponent - largest_exponent);
}

void convert_lengths(SceneDescription& scene, const HamiltonianInfo& info, double unit) {
    if (unit == 1) return;
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        scene.space.parameters[i].second *= std::pow(unit, -power_of_length(info.parameters[i].unit));
    divide(scene.space.center, unit);
    scene.integrator.escape_radius /= unit;
    divide(scene.camera.position, unit);
    divide(scene.camera.look_at, unit);
    scene.camera.height /= unit;
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
