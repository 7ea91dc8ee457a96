/// Support for tests of stated velocities: scenes of black holes as formulas, and the ray through the centre of a
/// picture.
#pragma once

#include "tests/support/plan_fixture.h"

#include "accuracy/ray_errors.h"

#include <string>

namespace kagero::test {

/// Returns true if the kernel modules were built with this Hamiltonian.
inline bool is_available(const std::string& name) {
    const Catalogue built = catalogue("auto");
    return built.hamiltonian_named(name) != nullptr;
}

/// The end of a camera ray through the centre of the picture, its sky, and its redshift.
struct CentralRay {
    RayEnd end;
    SkyView sky;
    double redshift;
};
inline CentralRay central_ray(const Plan& plan) {
    const FilmDescription& film = plan.description().film;
    const CameraRay ray = camera_ray(plan, 0.5 * film.width, 0.5 * film.height);
    std::vector<RayEnd> ends;
    trace(plan, {ray.start}, ends);
    const RayEnd end = to_hamiltonian_coordinates(plan, ends[0]);
    return {end, sky_view(plan.scene->sources.skies, end), redshift_of(plan, {&end, &ray})};
}

/// Returns the message of the InputError that the plan of a scene throws; "" if it throws none.
inline std::string refusal(const std::string& text, const Overrides& overrides) {
    try {
        plan_of_text(text, overrides);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// A camera and a sky, without a space.
inline const std::string camera = R"toml([integrator]
escape_radius = 60
[camera]
position = [0, -29.5, 5.2]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 50
[film]
size = [48, 32]
[sky]
checker = true
)toml";
/// A disk around the origin.
inline const std::string disk = R"toml([[object]]
name = "disk"
shape = "disk"
center = [0, 0, 0]
inner = 1.6
outer = 15
)toml";
/// Black holes as formulas, in Kerr–Schild coordinates.
inline const std::string schwarzschild = R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2 - rg/R*(pt + (x*px + y*py + z*pz)/R)^2)"
capture = "R - rg"
[space.constants]
pt = 1
rg = 1
[space.let]
R = "sqrt(x^2 + y^2 + z^2)"
)toml";
inline const std::string kerr = R"toml([space]
hamiltonian = "formula"
H = "0.5*(px^2 + py^2 + pz^2 - pt^2) - M*R^3/(R^4 + a^2*z^2)*(pt + lp)^2"
capture = "R - 1.001*(M + sqrt(M^2 - a^2))"
[space.constants]
pt = 1
M = 0.5
a = 0.4
[space.let]
b = "x^2 + y^2 + z^2 - a^2"
R = "sqrt(0.5*(b + sqrt(b^2 + 4*a^2*z^2)))"
lp = "((R*x - a*y)*px + (R*y + a*x)*py)/(R^2 + a^2) + z*pz/R"
)toml";

}  // namespace kagero::test
