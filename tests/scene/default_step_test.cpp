// Tests of the default step, which is proportional to a length of the space. Each Hamiltonian declares this length as
// an expression of its parameters (`step_goes_with`).
#include "tests/support/plan_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace kagero::test {
namespace {

double default_step(const std::string& hamiltonian, const std::vector<Override>& overrides = {}) {
    static const Catalogue known = catalogue("auto");
    const std::string text = "[space]\nhamiltonian = \"" + hamiltonian +
                             "\"\n[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\n[film]\nsize = [4, 4]\n";
    return load_scene_text(text, KAGERO_SCENES "/steps.toml", overrides, known).integrator.step;
}

std::string to_toml(double number) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", number);
    return text;
}

// All lengths of each medium are multiplied by 7.
TEST(DefaultStep, IsProportionalToTheLengthsOfAMedium) {
    const Catalogue known = catalogue("auto");
    int media = 0;
    for (std::uint32_t i = 0; i < known.hamiltonian_count; ++i) {
        const HamiltonianInfo& info = known.hamiltonians[i];
        if (!info.step_goes_with) continue;
        EXPECT_DOUBLE_EQ(default_step(info.name), info.step) << info.name;
        std::vector<Override> overrides{"integrator.escape_radius=350"};
        for (std::uint32_t k = 0; k < info.parameter_count; ++k) {
            const ParameterInfo& parameter = info.parameters[k];
            overrides.push_back(std::string("space.") + parameter.name + '=' +
                                to_toml(parameter.default_value * std::pow(7, power_of_length(parameter.unit))));
        }
        EXPECT_NEAR(default_step(info.name, overrides), 7 * info.step, 1e-12 * info.step) << info.name;
        ++media;
    }
    EXPECT_GE(media, 8);
}

// The default step of a spacetime is a pure number if H is rescaled, and a length if H is not rescaled.
TEST(DefaultStep, IsALengthInSpacetimesWithoutRescaling) {
    const struct {
        const char *space, *size, *method;
    } spacetimes[] = {{"schwarzschild", "space.rg=7", "satoh4-nine"},
                      {"schwarzschild", "space.rg=7", "ks-s10"},
                      {"kerr", "space.mass=7", "gauss8"},
                      {"wormhole", "space.throat=7", "gauss8"}};
    for (const auto& [space, size, method] : spacetimes) {
        const Override with_method = std::string("integrator.method=") + method;
        const Override without_rescaling = "integrator.rescale=none";
        const double step_at_default_lengths = default_step(space, {"integrator.symmetry=none"});
        EXPECT_EQ(default_step(space, {with_method, without_rescaling}), step_at_default_lengths) << space;
        EXPECT_EQ(default_step(space, {size, with_method, without_rescaling}), 7 * step_at_default_lengths) << space;
        const bool is_rescaled = method == std::string("gauss8");
        EXPECT_EQ(default_step(space, {size, with_method}), (is_rescaled ? 1 : 7) * step_at_default_lengths)
            << space << ' ' << method;
        EXPECT_EQ(default_step(space, {size, with_method, without_rescaling, "integrator.step=0.125"}), 0.125) << space;
    }
    // The step of a method in the orbit plane is an angle, which does not depend on lengths.
    EXPECT_EQ(default_step("fisheye", {"space.radius=7", "integrator.method=orbit-srkn11"}), 0.2);
}

// The index of refraction changes with height, and it has a ripple along x. Each of these two variations has a length
// scale, and the default step is proportional to the shorter one.
TEST(DefaultStep, IsProportionalToTheShortestLength) {
    for (const char* space : {"duct", "mirage"}) {
        const double step_at_default_lengths = default_step(space);
        for (const char* wavenumber : {"space.wavenumber=0", "space.wavenumber=0.1", "space.wavenumber=1"}) {
            const double wide_ripple = default_step(space, {wavenumber});
            EXPECT_GE(wide_ripple, step_at_default_lengths) << space << wavenumber;
            EXPECT_LE(wide_ripple, 1.01 * step_at_default_lengths) << space << wavenumber;
            EXPECT_NEAR(default_step(space, {wavenumber, "space.n3=2.4"}), 0.5 * wide_ripple, 1e-12)
                << space << wavenumber;
        }
        EXPECT_NEAR(default_step(space, {"space.wavenumber=18.849555921538759"}), 0.5 * step_at_default_lengths, 1e-12)
            << space;
        // Rays are straight: the step is the radius of the escape sphere.
        EXPECT_EQ(default_step(space, {"space.wavenumber=0", "space.n3=0"}), 50) << space;
    }
    EXPECT_EQ(default_step("mirage", {"space.n3=-0.3"}), default_step("mirage"));
}

}  // namespace
}  // namespace kagero::test
