// Tests the kernel modules of different instruction sets. The modules must compute the same ray ends to rounding, only
// the selected module may be loaded, and each must export exactly one symbol.
#include "modules/modules.h"
#include "tests/support/plan_fixture.h"
#include "tests/support/program.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

namespace kagero::test {
namespace {

std::string without_trailing_spaces(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    return text;
}

/// Returns the output of a shell command.
std::string output_of(const std::string& command) {
    std::string text;
    FILE* pipe = popen(command.c_str(), "r");
    for (int c; (c = fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    return text;
}

/// Settings that select the orbit plane, and the general path with explicit and with implicit steps.
const Overrides method_settings[] = {{}, {"integrator.symmetry=none"}, {"integrator.method=gauss8"}};

/// Traces the given starts in the scene room.toml. If `starts` is empty, first sets it to the rays of 64 × 64 pixels of
/// the camera and 500 rays from random positions in random directions.
std::vector<RayEnd> ends_in_room(const std::string& isa, std::vector<RayStart>& starts, const Overrides& method) {
    Options options = with_strategy("packet");
    options.isa = isa;
    Overrides overrides{"film.size=[64,64]"};
    overrides.insert(overrides.end(), method.begin(), method.end());
    const auto plan = plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    EXPECT_EQ(plan->module().isa, isa);
    if (starts.empty()) {  // all instruction sets use the same starts
        for (std::uint32_t y = 0; y < 64; ++y)
            for (std::uint32_t x = 0; x < 64; ++x) starts.push_back(pixel_ray_start(*plan, x, y));
        std::mt19937 random(7);
        std::uniform_real_distribution<double> coordinate(-0.95, 0.95);
        std::vector<RayInput> rays(500);
        for (RayInput& ray : rays)
            ray = {{coordinate(random), coordinate(random), coordinate(random)},
                   {coordinate(random), coordinate(random), 0.3}};
        for (const RayStart& start : start_rays(*plan, rays)) starts.push_back(start);
    }
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    return ends;
}

/// Returns the factor by which each ray amplifies a change of its start: |Δq(end)| / |Δq(start)| for a shift of 1e-6.
/// The factor is at least 1, and infinite if the shifted ray ends with another status or on another primitive.
std::vector<double> amplification_factors(const std::vector<RayStart>& starts, const std::vector<RayEnd>& ends,
                                  const Overrides& method) {
    std::vector<RayStart> shifted = starts;
    constexpr double shift = 1e-6;
    for (RayStart& start : shifted)
        for (double& x : start.q) x += shift;
    const std::string isa = supported_isas()[0];
    const auto shifted_ends = ends_in_room(isa, shifted, method);
    std::vector<double> factors;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double* a = ends[i].q;
        const double* b = shifted_ends[i].q;
        const bool same = ends[i].status == shifted_ends[i].status && ends[i].primitive == shifted_ends[i].primitive;
        factors.push_back(same ? std::max(1.0, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / shift)
                               : std::numeric_limits<double>::infinity());
    }
    return factors;
}

// Modules differ in the use of fused multiply-add, and in the rounding of reciprocals and reciprocal square roots. The
// tolerance is 500 rounding errors of coordinates of order 1, times the amplification of the ray. Rays with infinite
// amplification are left out; they must be fewer than 1 % of all rays.
TEST(Isas, RayEndsAreEqualToRounding) {
    const auto isas = supported_isas();
    if (isas.size() < 2) GTEST_SKIP() << "Only one instruction set is supported.";
    for (const Overrides& method : method_settings) {
        std::vector<RayStart> starts;
        const auto reference = ends_in_room(isas[0], starts, method);
        const auto factors = amplification_factors(starts, reference, method);
        for (std::size_t k = 1; k < isas.size(); ++k) {
            const auto ends = ends_in_room(isas[k], starts, method);
            std::size_t left_out = 0;
            for (std::size_t i = 0; i < ends.size(); ++i) {
                if (!std::isfinite(factors[i]) && ++left_out) continue;
                const std::string number = std::to_string(&method - method_settings);
                SCOPED_TRACE(isas[k] + ", method " + number + ", ray " + std::to_string(i));
                ASSERT_EQ(ends[i].status, reference[i].status);
                ASSERT_EQ(ends[i].surface, reference[i].surface);
                ASSERT_EQ(ends[i].primitive, reference[i].primitive);
                const double bound = 500 * std::numeric_limits<double>::epsilon() * factors[i];
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(ends[i].q[c], reference[i].q[c], bound);
            }
            EXPECT_LT(left_out, starts.size() / 100) << isas[k];
        }
    }
}

/// Returns status, object and colour of each pixel of the scene room.toml: five numbers per pixel.
std::vector<float> picture_of_room(const std::string& isa, const Overrides& method) {
    Options options;
    options.isa = isa;
    Overrides overrides{"film.size=[64,64]", "film.layers=[\"color\",\"status\",\"object\"]"};
    overrides.insert(overrides.end(), method.begin(), method.end());
    const auto plan = plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    Film film(64, 64, plan->description().film.layers);
    render(*plan, film);
    std::vector<float> picture;
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) {
            picture.push_back(*film.pixel("status", x, y));
            picture.push_back(*film.pixel("object", x, y));
            for (int c = 0; c < 3; ++c) picture.push_back(film.pixel("color", x, y)[c]);
        }
    return picture;
}

// A ray that is within about 1e-13 of an edge may hit the surface on either side, so that one of the 4096 pixels may
// differ.
TEST(Isas, PicturesAreEqual) {
    const auto isas = supported_isas();
    if (isas.size() < 2) GTEST_SKIP() << "Only one instruction set is supported.";
    for (const Overrides& method : method_settings) {
        const std::vector<float> reference = picture_of_room(isas[0], method);
        for (std::size_t k = 1; k < isas.size(); ++k) {
            const std::vector<float> picture = picture_of_room(isas[k], method);
            int different = 0;
            for (std::size_t i = 0; i < reference.size(); i += 5)
                different += !std::equal(&reference[i], &reference[i] + 5, &picture[i]);
            EXPECT_LE(different, 1) << isas[k] << ", method " << &method - method_settings;
        }
    }
}

TEST(Isas, SelectedModuleIsLoaded) {
    for (const std::string& isa : supported_isas()) {
        EXPECT_EQ(load_module(isa).isa, isa);
        const std::string maps = text_of("/proc/self/maps");
        EXPECT_NE(maps.find("kagero-kernels-" + isa + ".so"), std::string::npos);
    }
    EXPECT_EQ(load_module("auto").isa, supported_isas().front());
    EXPECT_THROW(load_module("sse9"), InputError);
}

TEST(Isas, ModulesExportOneSymbol) {
    for (const IsaInfo& isa : find_isas())
        EXPECT_EQ(without_trailing_spaces(output_of("nm -D --defined-only '" + isa.path + "' | awk '{print $3}'")),
                  "kagero_kernels")
            << isa.name;
}

class IsaProgram : public ProgramTest {};

// The log of the dynamic loader lists the modules that were opened.
TEST_F(IsaProgram, LoadsOnlyTheSelectedModule) {
    for (const std::string& isa : supported_isas()) {
        const Outcome outcome =
            run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --quiet --json --isa " + isa,
                "LD_DEBUG=files LD_DEBUG_OUTPUT=opened");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(nlohmann::json::parse(outcome.out)["isa"], isa);
        const std::string opened = output_of(
            "cd '" + directory_.string() + "' && grep -oh 'kagero-kernels-[a-z0-9]*' opened.* | sort -u; rm opened.*");
        EXPECT_EQ(without_trailing_spaces(opened), "kagero-kernels-" + isa);
    }
    const std::string least_isa = supported_isas().back();
    const Outcome outcome =
        run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --quiet --json", "KAGERO_ISA=" + least_isa);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(outcome.out)["isa"], least_isa);
}

// `auto` selects the best instruction set. Duplicates in the list are removed.
TEST_F(IsaProgram, AutoInAListSelectsTheBestInstructionSetOnce) {
    const std::string best = supported_isas().front(), least_isa = supported_isas().back();
    for (const std::string& list : {std::string("auto,auto"), "auto," + least_isa, least_isa + ",auto"}) {
        const Outcome outcome = run("compare '" KAGERO_SCENES
                                    "/room.toml' --size 16x16 --rounds 1 --strategy packet --quiet --json --isa " +
                                    list);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::set<std::string> found, expected{best};
        if (list != "auto,auto") expected.insert(least_isa);
        const auto report = nlohmann::json::parse(outcome.out);
        for (const auto& row : report["rows"]) found.insert(row["isa"].get<std::string>());
        EXPECT_EQ(found, expected) << list;
    }
}

TEST_F(IsaProgram, RefusesUnknownInstructionSets) {
    for (const char* command :
         {"check '" KAGERO_SCENES "/room.toml' --isa avx3", "compare '" KAGERO_SCENES "/room.toml' --isa auto,avx3"}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.status, 2);
        EXPECT_NE(outcome.err.find("avx3"), std::string::npos) << outcome.err;
    }
}

// `compare` accepts a list of instruction sets or `all`; `render` accepts only one.
TEST_F(IsaProgram, OnlyComparisonsAcceptSeveralInstructionSets) {
    const auto isas = supported_isas();
    std::string list;
    for (const std::string& isa : isas) list += (list.empty() ? "" : ",") + isa;
    for (const std::string& value : {list, std::string("all")}) {
        const Outcome outcome = run("compare '" KAGERO_SCENES
                                    "/room.toml' --size 16x16 --rounds 1 --strategy packet --quiet --json --isa " +
                                    value);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::set<std::string> found;
        const auto report = nlohmann::json::parse(outcome.out);
        for (const auto& row : report["rows"]) found.insert(row["isa"].get<std::string>());
        EXPECT_EQ(found, std::set<std::string>(isas.begin(), isas.end()));
    }
    EXPECT_EQ(run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --isa all").status, 2);
}

}  // namespace
}  // namespace kagero::test
