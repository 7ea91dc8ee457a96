// Compares rays and redshifts of the metrics in docs/spacetimes with closed forms and quadratures of the printed line
// elements. The script spacetimes_reference.py computes these values without Hamilton's equations, and writes them to
// spacetimes_reference.json.
#include "tests/support/velocity_scenes.h"

#include "tuning/resolve.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>


namespace kagero::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path folder = fs::path(KAGERO_SOURCE) / "docs/spacetimes";

/// Returns the names of the scenes in docs/spacetimes.
std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Returns the checks in spacetimes_reference.json.
const std::vector<json>& all_checks() {
    static const std::vector<json> all = [] {
        std::ifstream file(fs::path(KAGERO_SOURCE) / "tests/physics/spacetimes_reference.json");
        return json::parse(file).get<std::vector<json>>();
    }();
    return all;
}

/// Returns the constants and keys of the scene that a check replaces.
Overrides overrides_of(const json& check) {
    Overrides overrides;
    const json constants = check.value("constants", json::object()), settings = check.value("settings", json::object());
    for (const auto& [name, value] : constants.items())
        overrides.emplace_back("space.constants." + name + '=' + value.dump());
    for (const auto& [key, value] : settings.items()) overrides.emplace_back(key + '=' + value.dump());
    return overrides;
}

double difference(const json& expected, const double (&actual)[3]) {
    double difference = 0, scale = 1;
    for (int i = 0; i < 3; ++i) {
        difference = std::max(difference, std::abs(actual[i] - expected[std::size_t(i)].get<double>()));
        scale = std::max(scale, std::abs(expected[std::size_t(i)].get<double>()));
    }
    return difference / scale;
}

/// Returns the end of the ray of a check, traced as by `kagero trace`. Objects are removed from the scene unless the
/// ray must hit one.
RayEnd end_of(const json& check) {
    Options options;
    options.threads = 1;
    options.parameter = true;
    options.energy_error = true;
    options.time = check.contains("time");
    const std::string path = (folder / (check["scene"].get<std::string>() + ".toml")).string();
    Overrides overrides = overrides_of(check);
    overrides.emplace_back("integrator.symmetry=none");
    SceneDescription scene = load_scene(path, overrides, catalogue(options.isa));
    if (check["status"] != "hit") scene.objects.clear();
    Plan plan = resolve(std::move(scene), options, Purpose::ray_list);
    if (check.contains("parameter")) plan.run.parameter_limit = check["parameter"];
    const auto vector = [&](const char* key) {
        return Double3{check[key][0].get<double>(), check[key][1].get<double>(), check[key][2].get<double>()};
    };
    std::vector<RayEnd> ends;
    trace(plan, start_rays(plan, {{vector("position"), vector("direction")}}), ends);
    return ends.at(0);
}

void compare_ray(const json& check) {
    const RayEnd end = end_of(check);
    ASSERT_EQ(name_of(end.status), check["status"].get<std::string>());
    const double tolerance = check.value("tolerance", 0.0);
    if (check.contains("end_position")) {
        EXPECT_LE(difference(check["end_position"], end.q), tolerance);
    }
    if (check.contains("end_direction")) {
        EXPECT_LE(difference(check["end_direction"], end.v), tolerance);
    }
    if (check.contains("end_momentum")) {
        EXPECT_LE(difference(check["end_momentum"], end.p), tolerance);
    }
    if (check.contains("time")) {
        const double time = check["time"];
        EXPECT_LE(std::abs(end.time - time), tolerance * std::max(1.0, std::abs(time)));
    }
    const double r = std::hypot(end.q[0], end.q[1], end.q[2]);
    if (check.contains("farther_than")) {
        EXPECT_GT(r, check["farther_than"].get<double>());
    }
    if (check.contains("nearer_than")) {
        EXPECT_LT(r, check["nearer_than"].get<double>());
    }
}

/// Compares the redshift of the ray through the centre of the picture.
void compare_redshift(const json& check) {
    const std::string path = (folder / (check["scene"].get<std::string>() + ".toml")).string();
    const CentralRay ray = central_ray(*plan_of_file(path, overrides_of(check)));
    EXPECT_EQ(name_of(ray.end.status), check["status"].get<std::string>());
    EXPECT_NEAR(ray.redshift / check["redshift"].get<double>(), 1, check["tolerance"].get<double>());
}

class Spacetime : public ::testing::TestWithParam<std::string> {};

TEST_P(Spacetime, AgreesWithTheLiterature) {
    int count = 0;
    for (const json& check : all_checks()) {
        if (check["scene"] != GetParam()) continue;
        SCOPED_TRACE(check["what"].get<std::string>() + " (" + check["source"].get<std::string>() + ')');
        if (check.contains("redshift")) compare_redshift(check);
        else compare_ray(check);
        ++count;
    }
    EXPECT_GE(count, 2);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Spacetime, ::testing::ValuesIn(scene_names()), [](const auto& scene) {
    std::string name = scene.param;
    std::replace(name.begin(), name.end(), '-', '_');
    return name;
});

TEST(Spacetimes, EveryReferenceBelongsToAScene) {
    const std::vector<std::string> names = scene_names();
    EXPECT_EQ(names.size(), 24u);
    for (const json& check : all_checks())
        EXPECT_TRUE(std::binary_search(names.begin(), names.end(), check["scene"].get<std::string>())) << check;
}

}  // namespace
}  // namespace kagero::test
