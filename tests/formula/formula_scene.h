/// Scenes whose Hamiltonian is a formula, their rays, and the messages of refused scenes.
#pragma once

#include "error.h"
#include "tests/support/plan_fixture.h"

namespace kagero::test {

/// The tables of a scene that describe its view.
inline const std::string view_text = "\n[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n";

/// The table [space] of a formula whose rays are straight. Further keys of [space] can be appended.
inline const std::string straight_space = "[space]\nhamiltonian = \"formula\"\nH = \"0.5*(px^2 + py^2 + pz^2 - 1)\"\n";

/// The medium `mirage` as a formula.
inline constexpr const char* mirage_formula =
    "[space]\nhamiltonian = \"formula\"\nH = \"0.5*n*(px^2 + py^2 + pz^2)\"\nH0 = 0.5\ndomain = \"n - 0.05\"\n"
    "length_scale = \"0.2*max(n, 0.05)/sqrt((0.09*pi)^2 + (0.9*z^2)^2)\"\n"
    "[space.let]\nn = \"0.85 - 0.3*z^3 + 0.03*cos(3*pi*x)\"\n";

/// Returns rays that start at one point in various directions.
inline std::vector<RayInput> fan(const double (&origin)[3]) {
    std::vector<RayInput> rays;
    for (int i = 0; i < 37; ++i)
        rays.push_back({{origin[0], origin[1], origin[2]}, {1, 0.04 * i - 0.9, 0.3 - 0.01 * i}});
    return rays;
}

/// Returns the ends of rays in the space that `text` describes.
inline std::vector<RayEnd> traced(const std::string& text, const Overrides& overrides, const std::string& strategy,
                                  const std::vector<RayInput>& rays, const std::string& isa = "auto") {
    Options options = with_strategy(strategy);
    options.isa = isa;
    options.energy_error = true;
    const auto plan = plan_of_text(text + view_text, overrides, options, false);
    std::vector<RayEnd> ends;
    trace(*plan, start_rays(*plan, rays), ends);
    return ends;
}

/// Returns the message of the InputError for a scene with this space, or "" if the scene is accepted.
inline std::string refusal(const std::string& text, const Overrides& overrides = {}) {
    try {
        plan_of_text(text + view_text, overrides, with_strategy("packet"));
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace kagero::test
