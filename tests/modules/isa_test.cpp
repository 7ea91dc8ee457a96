// Every instruction set follows the same rays; the one asked for is the one that runs; each module shows one symbol.
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

std::string without_spaces(std::string text) {
    while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
    return text;
}

/// What a shell command prints.
std::string output_of(const std::string& command) {
    std::string text;
    FILE* pipe = popen(command.c_str(), "r");
    for (int c; (c = fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    return text;
}

/// In the plane of the orbit, and in space by explicit and implicit steps.
const Overrides ways[] = {{}, {"integrator.symmetry=none"}, {"integrator.method=gauss8"}};

/// Rays of the room's camera, 64², and 500 from all over the room in all directions.
std::vector<RayEnd> ends_in_room(const std::string& isa, std::vector<RayStart>& starts, const Overrides& way) {
    Options options = with_strategy("packet");
    options.isa = isa;
    Overrides overrides{"film.size=[64,64]"};
    overrides.insert(overrides.end(), way.begin(), way.end());
    const auto plan = plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    EXPECT_EQ(plan->module().isa, isa);
    if (starts.empty()) {  // once: rays are the same to the last bit for all
        for (std::uint32_t y = 0; y < 64; ++y)
            for (std::uint32_t x = 0; x < 64; ++x) starts.push_back(pixel_ray(*plan, x, y));
        std::mt19937 random(7);
        std::uniform_real_distribution<double> place(-0.95, 0.95);
        std::vector<RayInput> rays(500);
        for (RayInput& ray : rays)
            ray = {{place(random), place(random), place(random)}, {place(random), place(random), 0.3}};
        for (const RayStart& start : start_rays(*plan, rays)) starts.push_back(start);
    }
    std::vector<RayEnd> ends;
    trace(*plan, starts, ends);
    return ends;
}

/// How much a ray spreads what it starts with: |Δq(end)| / |Δq(start)| for start positions a millionth apart.
std::vector<double> amplification(const std::vector<RayStart>& starts, const std::vector<RayEnd>& ends,
                                  const Overrides& way) {
    std::vector<RayStart> moved = starts;
    constexpr double shift = 1e-6;
    for (RayStart& start : moved)
        for (double& x : start.q) x += shift;
    const std::string isa = supported_isas()[0];
    const auto moved_ends = ends_in_room(isa, moved, way);
    std::vector<double> factors;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const double* a = ends[i].q;
        const double* b = moved_ends[i].q;
        const bool same = ends[i].status == moved_ends[i].status && ends[i].primitive == moved_ends[i].primitive;
        factors.push_back(same ? std::max(1.0, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) / shift)
                               : std::numeric_limits<double>::infinity());
    }
    return factors;
}

// Fused products in one module and not in the other, and other square roots, are roundings of coordinates of order one:
// up to a few hundred in a ray, each spread by what the ray itself spreads. Where that cannot be told, because a
// neighbour a millionth away ends otherwise, the ray is counted and left out.
TEST(Isas, FollowTheSameRays) {
    const auto isas = supported_isas();
    if (isas.size() < 2) GTEST_SKIP() << "one instruction set alone";
    for (const Overrides& way : ways) {
        std::vector<RayStart> starts;
        const auto reference = ends_in_room(isas[0], starts, way);
        const auto spread = amplification(starts, reference, way);
        for (std::size_t k = 1; k < isas.size(); ++k) {
            const auto ends = ends_in_room(isas[k], starts, way);
            std::size_t left_out = 0;
            for (std::size_t i = 0; i < ends.size(); ++i) {
                if (!std::isfinite(spread[i]) && ++left_out) continue;
                SCOPED_TRACE(isas[k] + ", way " + std::to_string(&way - ways) + ", ray " + std::to_string(i));
                ASSERT_EQ(ends[i].status, reference[i].status);
                ASSERT_EQ(ends[i].surface, reference[i].surface);
                ASSERT_EQ(ends[i].primitive, reference[i].primitive);
                const double bound = 500 * std::numeric_limits<double>::epsilon() * spread[i];
                for (int c = 0; c < 3; ++c) ASSERT_NEAR(ends[i].q[c], reference[i].q[c], bound);
            }
            EXPECT_LT(left_out, starts.size() / 100) << isas[k];
        }
    }
}

/// Status, object and colour of every pixel of the room.
std::vector<float> picture_of_room(const std::string& isa, const Overrides& way) {
    Options options;
    options.isa = isa;
    Overrides overrides{"film.size=[64,64]", "film.layers=[\"color\",\"status\",\"object\"]"};
    overrides.insert(overrides.end(), way.begin(), way.end());
    const auto plan = plan_of_file(KAGERO_SCENES "/room.toml", overrides, options);
    Film film(64, 64, plan->description().film.layers);
    render(*plan, film);
    std::vector<float> picture;
    for (std::uint32_t y = 0; y < 64; ++y)
        for (std::uint32_t x = 0; x < 64; ++x) {
            picture.push_back(*film.pixel("status", x, y)), picture.push_back(*film.pixel("object", x, y));
            for (int c = 0; c < 3; ++c) picture.push_back(film.pixel("color", x, y)[c]);
        }
    return picture;
}

TEST(Isas, DrawTheSamePicture) {
    const auto isas = supported_isas();
    if (isas.size() < 2) GTEST_SKIP() << "one instruction set alone";
    for (const Overrides& way : ways) {
        const std::vector<float> reference = picture_of_room(isas[0], way);
        // A ray within some 1e-13 of an edge may fall on either side: hardly one of 4096.
        for (std::size_t k = 1; k < isas.size(); ++k) {
            const std::vector<float> picture = picture_of_room(isas[k], way);
            int different = 0;
            for (std::size_t i = 0; i < reference.size(); i += 5)
                different += !std::equal(&reference[i], &reference[i] + 5, &picture[i]);
            EXPECT_LE(different, 1) << isas[k] << ", way " << &way - ways;
        }
    }
}

TEST(Isas, AskedForIsLoaded) {
    for (const std::string& isa : supported_isas()) {
        EXPECT_EQ(load_module(isa).isa, isa);
        const std::string maps = text_of("/proc/self/maps");
        EXPECT_NE(maps.find("kagero-kernels-" + isa + ".so"), std::string::npos);
    }
    EXPECT_EQ(load_module("auto").isa, supported_isas().front());
    EXPECT_THROW(load_module("sse9"), InputError);
}

TEST(Isas, ModulesShowOneSymbol) {
    for (const IsaInfo& isa : find_isas())
        EXPECT_EQ(without_spaces(output_of("nm -D --defined-only '" + isa.path + "' | awk '{print $3}'")),
                  "kagero_kernels")
            << isa.name;
}

class IsaProgram : public ProgramTest {};

// The loader is asked which modules it opened: the code of the others cannot have run.
TEST_F(IsaProgram, RunsTheOneAskedForAlone) {
    for (const std::string& isa : supported_isas()) {
        const Outcome outcome =
            run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --quiet --json --isa " + isa,
                "LD_DEBUG=files LD_DEBUG_OUTPUT=opened");
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        EXPECT_EQ(nlohmann::json::parse(outcome.out)["isa"], isa);
        const std::string opened = output_of(
            "cd '" + directory_.string() + "' && grep -oh 'kagero-kernels-[a-z0-9]*' opened.* | sort -u; rm opened.*");
        EXPECT_EQ(without_spaces(opened), "kagero-kernels-" + isa);
    }
    const std::string last = supported_isas().back();
    const Outcome outcome =
        run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --quiet --json", "KAGERO_ISA=" + last);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(nlohmann::json::parse(outcome.out)["isa"], last);
}

TEST_F(IsaProgram, TakesTheBestOnceAmongOthers) {
    const std::string best = supported_isas().front(), last = supported_isas().back();
    for (const std::string& wish : {std::string("auto,auto"), "auto," + last, last + ",auto"}) {
        const Outcome outcome = run("compare '" KAGERO_SCENES
                                    "/room.toml' --size 16x16 --rounds 1 --strategy packet --quiet --json --isa " +
                                    wish);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::set<std::string> seen, should{best};
        if (wish != "auto,auto") should.insert(last);
        const auto report = nlohmann::json::parse(outcome.out);
        for (const auto& row : report["rows"]) seen.insert(row["isa"].get<std::string>());
        EXPECT_EQ(seen, should) << wish;
    }
}

TEST_F(IsaProgram, RefusesOneItDoesNotKnow) {
    for (const char* command :
         {"check '" KAGERO_SCENES "/room.toml' --isa avx3", "compare '" KAGERO_SCENES "/room.toml' --isa auto,avx3"}) {
        const Outcome outcome = run(command);
        EXPECT_EQ(outcome.status, 2);
        EXPECT_NE(outcome.err.find("avx3"), std::string::npos) << outcome.err;
    }
}

// Verbs that set instruction sets side by side take several, the others one.
TEST_F(IsaProgram, TakesAListWhereSeveralAreCompared) {
    const auto isas = supported_isas();
    std::string list;
    for (const std::string& isa : isas) list += (list.empty() ? "" : ",") + isa;
    for (const std::string& wish : {list, std::string("all")}) {
        const Outcome outcome = run("compare '" KAGERO_SCENES
                                    "/room.toml' --size 16x16 --rounds 1 --strategy packet --quiet --json --isa " +
                                    wish);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        std::set<std::string> seen;
        const auto report = nlohmann::json::parse(outcome.out);
        for (const auto& row : report["rows"]) seen.insert(row["isa"].get<std::string>());
        EXPECT_EQ(seen, std::set<std::string>(isas.begin(), isas.end()));
    }
    EXPECT_EQ(run("render '" KAGERO_SCENES "/room.toml' --size 4x4 -o a.png --isa all").status, 2);
}

}  // namespace
}  // namespace kagero::test
