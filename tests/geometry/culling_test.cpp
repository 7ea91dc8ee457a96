// Tests of culling: pictures with and without culling must be identical.
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include <cmath>
#include <random>

namespace kagero::test {
namespace {

struct Scene {
    const char* name;
    std::string text;
    friend std::ostream& operator<<(std::ostream& out, const Scene& scene) { return out << scene.name; }
};

/// Returns a scene of random spheres, boxes and tilted parallelograms around a black hole. Some of these objects
/// intersect each other, and the camera is between the objects.
std::string random_objects() {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> coordinate(-3, 3), size(0.02, 0.5), share(0, 1);
    const auto numbers = [](std::initializer_list<double> list) {
        std::string text;
        for (const double number : list) text += (text.empty() ? "[" : ", ") + std::to_string(number);
        return text + "]";
    };
    std::string text =
        "space = { hamiltonian = \"schwarzschild\", rg = 0.2 }\ncamera = { position = [0.4, -1.7, 0.3], look_at = [0, "
        "0, 0], up = [0, 0, 1], fov = 100 }\n"
        "integrator.escape_radius = 12\n";
    for (int i = 0; i < 60; ++i) {
        const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
        if (std::hypot(x, y, z) < 0.8 || std::hypot(x - 0.4, y + 1.7, z - 0.3) < 0.6) continue;
        text += "[[object]]\n";
        if (i % 3 == 0)
            text += "shape = \"sphere\"\ncenter = " + numbers({x, y, z}) +
                    "\nradius = " + std::to_string(size(random)) + "\n";
        if (i % 3 == 1)
            text += "shape = \"box\"\nmin = " + numbers({x, y, z}) +
                    "\nmax = " + numbers({x + size(random), y + size(random), z + size(random)}) + "\n";
        if (i % 3 == 2)
            text += "shape = \"rectangle\"\norigin = " + numbers({x, y, z}) +
                    "\nedge_u = " + numbers({size(random), share(random), 0.3}) +
                    "\nedge_v = " + numbers({-0.4, size(random), share(random)}) + "\n";
    }
    return text;
}

const Scene scenes[] = {{"random_objects", random_objects()},
                        {"room", scene_text("room.toml")},
                        {"fisheye", scene_text("fisheye.toml")},
                        {"anisotropic", scene_text("formula-anisotropic.toml")}};

class Culling : public testing::TestWithParam<Scene> {};

// All layers must be equal bit for bit. The number of queries must decrease by at least 30 %.
TEST_P(Culling, ChangesNoPixel) {
    const Overrides methods[] = {{},
                                 {"integrator.method=gauss8", "integrator.step=0.7"},
                                 {"integrator.method=verlet", "integrator.step=0.1"}};
    for (const Overrides& method : methods)
        for (const char* precision : {"double", "float"}) {
            Options options = with_strategy("packet");
            options.precision = precision_named(precision);
            std::uint64_t queries[2];
            std::vector<Film> films;
            for (const bool culls : {true, false}) {
                Overrides overrides = method;
                overrides.insert(overrides.end(),
                                 {"film.size=[96,72]", "film.layers=[\"color\",\"status\",\"object\",\"steps\"]",
                                  culls ? "integrator.cull=auto" : "integrator.cull=none"});
                const auto plan = plan_of_text(GetParam().text, overrides, options);
                films.emplace_back(96, 72, plan->description().film.layers);
                queries[!culls] = render(*plan, films.back()).counters.queries;
            }
            for (const char* layer : {"color", "status", "object", "steps"})
                for (std::uint32_t y = 0; y < 72; ++y)
                    for (std::uint32_t x = 0; x < 96; ++x)
                        ASSERT_EQ(*films[0].pixel(layer, x, y), *films[1].pixel(layer, x, y))
                            << layer << " " << x << "," << y << " in " << precision;
            EXPECT_LT(queries[0], 0.7 * double(queries[1])) << precision;
        }
}
INSTANTIATE_TEST_SUITE_P(Scenes, Culling, testing::ValuesIn(scenes), [](const auto& scene) {
    return scene.param.name;
});

}  // namespace
}  // namespace kagero::test
