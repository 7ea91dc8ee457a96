/// Support for tests of scene files: a small catalogue of Hamiltonians and integrators, a valid scene, and temporary
/// scene files.
#pragma once

#include "scene/description.h"
#include "scene/load/load.h"
#include "scene/print.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace kagero::test {

inline const Catalogue& small_catalogue() {
    static const ParameterInfo radius{"rg", 0.1, 0, 1000, false, Unit::length, "radius of the horizon"};
    static const ParameterInfo throat{"throat", 1, 0, 1000, true, Unit::length, "radius of the throat"};
    static const HamiltonianInfo hamiltonians[] = {
        {"flat", "straight rays", "", "", "", nullptr, 0, false, false, 0, "verlet", 0.5},
        {"schwarzschild", "a black hole", "", "", "", &radius, 1, true, true, 0, "gauss8", 0.05},
        {"wormhole", "two universes", "", "", "", &throat, 1, true, false, 0, "gauss8", 0.05, nullptr, nullptr, false,
         false, false, false, true},
    };
    static const IntegratorInfo integrators[] = {
        {"verlet", 2, true, true, false, false, ""},
        {"gauss8", 8, true, true, true, false, ""},
        {"yoshida4", 4, true, true, false, false, ""},
    };
    static const Catalogue catalogue{hamiltonians, 3, integrators, 3, {"color", "status", "steps"}};
    return catalogue;
}

inline const char* const good_scene = R"([space]
hamiltonian = "schwarzschild"
rg = 0.08
[integrator]
step = 0.05
[camera]
position = [0, -3, 0]
look_at = [0, 0, 0]
up = [0, 0, 1]
fov = 60
[film]
size = [64, 48]
[sky]
color = [0, 0, 0.1]
[[object]]
name = "ball"
shape = "sphere"
center = [1, 0, 0]
radius = 0.25
[[object]]
name = "floor"
shape = "rectangle"
origin = [-1, -1, -1]
edge_u = [2, 0, 0]
edge_v = [0, 2, 0]
checker = [4, 4]
[[object]]
name = "hall"
shape = "room"
min = [-4, -4, -4]
max = [4, 4, 4]
[object.faces]
px = [1, 0, 0]
ny = { color = [0, 1, 0], checker = [2, 3] }
)";

/// Fixture with a temporary folder, which is created for each test and removed after it.
class SceneTest : public ::testing::Test {
protected:
    void SetUp() override {
        const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
        const std::string name = std::string("kagero-") + info->name() + '-' + std::to_string(getpid());
        directory_ = std::filesystem::temp_directory_path() / name;
        std::filesystem::create_directories(directory_);
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }

    std::string write(const std::string& name, const std::string& text) const {
        const std::string path = (directory_ / name).string();
        std::ofstream(path, std::ios::binary) << text;
        return path;
    }
    SceneDescription load(const std::string& text, const std::vector<Override>& overrides = {}) const {
        return load_scene(write("scene.toml", text), overrides, small_catalogue());
    }
    /// Returns the message of the InputError that is thrown when the text is loaded, or "" if none is thrown.
    std::string refusal(const std::string& text, const std::vector<Override>& overrides = {}) const {
        try {
            load(text, overrides);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }

    std::filesystem::path directory_;
};

}  // namespace kagero::test
