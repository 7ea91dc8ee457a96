// Tests of `kagero compare` on formulas, and on spaces for which the kernels that exist for comparison are not
// compiled. These kernels use machine code that is generated when the scene is loaded.
#include "tests/formula/formula_scene.h"
#include "tests/support/program.h"

#include "study/compare/compare.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>

namespace kagero::test {
namespace {

using nlohmann::json;

class ComparedSpaces : public ::testing::Test {
protected:
    void SetUp() override {
        if (!KAGERO_COMPILER_BUILT) GTEST_SKIP() << "the compiler module is not built";
    }
};

constexpr std::uint32_t width = 16, height = 12;

/// Returns the description of a scene without objects, whose space has its default parameters.
SceneDescription scene_in(const std::string& hamiltonian, const std::string& method, bool far = false) {
    const std::string path = (std::filesystem::temp_directory_path() / "kagero-compared-space.toml").string();
    std::ofstream(path) << "[space]\nhamiltonian = \"" << hamiltonian << "\"\n[camera]\nposition = "
                        << (far ? "[1.5, -10, 2]\n" : "[0.3, -2, 0.4]\n")
                        << "look_at = [0, 0, 0]\nup = [0, 0, 1]\n[film]\nsize = [" << width << ", " << height << "]\n"
                        << "[integrator]\nmax_steps = 300\n"
                        << (method.empty() ? "" : "method = \"" + method + "\"\n");
    return load_scene(path, {}, catalogue("auto"));
}

std::vector<RayEnd> ends_of(Plan plan, const KernelInfo& kernel) {
    plan.run.kernel = &kernel;
    std::vector<RayStart> starts;
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x) starts.push_back(pixel_ray_start(plan, x, y));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends);
    return ends;
}

/// Returns the number of ray ends whose status differs, or whose position differs by more than the tolerance.
int different_ends(const std::vector<RayEnd>& a, const std::vector<RayEnd>& b, double tolerance) {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        double distance = 0, size = 1;
        for (int c = 0; c < 3; ++c) {
            distance = std::max(distance, std::abs(a[i].q[c] - b[i].q[c]));
            size = std::max(size, std::abs(b[i].q[c]));
        }
        if (a[i].status != b[i].status || !(distance <= tolerance * size)) ++count;
    }
    return count;
}

bool same_bits(const std::vector<RayEnd>& a, const std::vector<RayEnd>& b) {
    for (std::size_t i = 0; i < a.size(); ++i)
        if (a[i].status != b[i].status || std::memcmp(a[i].q, b[i].q, sizeof a[i].q) != 0 ||
            std::memcmp(a[i].p, b[i].p, sizeof a[i].p) != 0)
            return false;
    return true;
}

/// Traces the rays of a space with every kernel that uses machine code. Ray ends in double agree with those of the
/// scalar code of the space, except at most four that depend on rounding. Packets of any width return the same bits.
void compare_kernels(const ComparedPlan& built_in, const ComparedPlan& generated, std::set<Form>& forms) {
    const Plan& plan = generated.plan;
    const auto expected = ends_of(built_in.plan, *find_variant(built_in.plan, plan.method().name, Strategy::scalar,
                                                               Precision::float64, 0)->kernel);
    std::map<Precision, std::vector<RayEnd>> packet_ends;
    std::set<std::pair<Precision, std::uint32_t>> widths;
    for (std::uint32_t k = 0; k < plan.module().kernel_count; ++k) {
        const KernelInfo& kernel = plan.module().kernels[k];
        if (!can_supplement(kernel) || refusal_of(*plan.scene, kernel, plan.run.method)) continue;
        SCOPED_TRACE(std::string(name_of(kernel.strategy)) + ' ' + name_of(kernel.form) + ' ' +
                     name_of(kernel.precision) + ' ' + std::to_string(kernel.registers));
        const std::vector<RayEnd> ends = ends_of(plan, kernel);
        forms.insert(kernel.form);
        if (kernel.precision == Precision::float64) {
            EXPECT_LE(different_ends(ends, expected, plan.method().adaptive ? 1e-4 : 1e-6), 4);
        }
        if (kernel.strategy != Strategy::packet) continue;
        widths.insert({kernel.precision, kernel.registers});
        const auto [first, is_first] = packet_ends.try_emplace(kernel.precision, ends);
        EXPECT_TRUE(is_first || same_bits(ends, first->second));
    }
    EXPECT_EQ(widths.size(), 6u) << "1, 2 and 4 registers in double and float";
}

TEST_F(ComparedSpaces, HaveMachineCodeThatTracesTheSameRays) {
    const Module& module = load_module("auto");
    int generated_spaces = 0;
    for (std::uint32_t h = 0; h + 1 < module.hamiltonian_count; ++h)  // the last is `formula`
        for (const char* method : {"", "gauss8", "verlet", "dp54"}) {
            SCOPED_TRACE(std::string(module.hamiltonians[h].name) + ' ' + method);
            if (*method && module.hamiltonians[h].discontinuous && std::string(method) != "gauss8") continue;
            std::vector<std::array<std::string, 2>> left_out;
            const HamiltonianInfo& info = module.hamiltonians[h];
            const std::vector<ComparedPlan> plans =
                plans_for_comparison(scene_in(info.name, method, info.spacetime), {}, left_out);
            EXPECT_TRUE(left_out.empty()) << left_out[0][1];
            if (plans.front().plan.scene->straight || plans.size() == 1) continue;
            const Plan& plan = plans[1].plan;
            if (refusal_of(*plan.scene, plan.run.method.integrator, plan.run.method.rescaled)) continue;
            EXPECT_EQ(code_of(*plan.scene), HamiltonianCode::generated);
            std::set<Form> forms;
            compare_kernels(plans[0], plans[1], forms);
            const bool has_stages = std::string(plan.method().name) == "gauss8";
            EXPECT_EQ(forms, has_stages ? (std::set{Form::none, Form::gradient, Form::stages})
                                        : (std::set{Form::none, Form::gradient}));
            ++generated_spaces;
        }
    EXPECT_GE(generated_spaces, 30);
}

/// Returns the options of one round on the best instruction set.
CompareOptions one_round() {
    CompareOptions options;
    options.isas = {supported_isas().back()};
    options.rounds = 1;
    return options;
}

SceneDescription small_mirage(const std::string& method) {
    return load_scene(scene_file("formula-mirage.toml"),
                      {{"film.size=[48,32]"}, {"integrator.method=\"" + method + "\""}}, catalogue("auto"));
}

// Pictures of packets and of stages in lanes are equal to that of the scalar kernel. Kernels of the form `gradient` add
// the terms of the gradient in another order.
TEST_F(ComparedSpaces, IncludeFormulas) {
    using Kernel = std::tuple<Strategy, Form, Precision, std::uint32_t>;
    std::set<Kernel> expected{{Strategy::scalar, Form::none, Precision::float64, 1},
                              {Strategy::scalar, Form::none, Precision::float32, 1}};
    for (const Precision precision : {Precision::float64, Precision::float32})
        for (const std::uint32_t registers : {1, 2, 4})
            expected.insert({Strategy::packet, Form::none, precision, registers});
    std::set<Kernel> found;
    std::set<Form> per_ray;
    const Comparison result = compare(small_mirage("gauss8"), one_round());
    for (const CompareRow& row : result.rows) {
        const KernelInfo& kernel = *row.kernel;
        SCOPED_TRACE(std::string(name_of(kernel.strategy)) + ' ' + name_of(kernel.form) + ' ' +
                     name_of(kernel.precision) + ' ' + std::to_string(kernel.registers));
        if (kernel.form == Form::none) found.insert({kernel.strategy, kernel.form, kernel.precision, kernel.registers});
        if (kernel.strategy == Strategy::per_ray) per_ray.insert(kernel.form);
        EXPECT_EQ(row.code, HamiltonianCode::generated);
        const bool exact = kernel.precision == Precision::float64 && kernel.form != Form::gradient;
        EXPECT_LE(row.flips, exact ? 0 : 48 * 32 / 100);
        if (exact) {
            EXPECT_EQ(row.max_difference, 0);
        }
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(per_ray, (std::set{Form::gradient, Form::stages}));
}

TEST_F(ComparedSpaces, StateWhyKernelsAreLeftOut) {
    setenv("KAGERO_FORMULA", "interpreted", 1);
    const Comparison formula = compare(small_mirage("verlet"), one_round()),
                     built_in = compare(scene_in("mirage", "verlet"), one_round());
    unsetenv("KAGERO_FORMULA");
    const auto reasons = [](const Comparison& result) {
        std::string all;
        for (const auto& [what, why] : result.left_out) all += what + ": " + why + "\n";
        return all;
    };
    for (const CompareRow& row : formula.rows) EXPECT_EQ(row.code, HamiltonianCode::interpreted);
    EXPECT_NE(reasons(formula).find("needs machine code, but the formula is interpreted"), std::string::npos);
    for (const CompareRow& row : built_in.rows) EXPECT_EQ(row.code, HamiltonianCode::built_in);
    EXPECT_NE(reasons(built_in).find("KAGERO_FORMULA is interpreted"), std::string::npos) << reasons(built_in);
    EXPECT_NE(reasons(compare(small_mirage("verlet"), one_round())).find("only Gauss-Legendre methods have stages"),
              std::string::npos);
}

class CompareTime : public ProgramTest {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("formula.toml", straight_space + "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\n[film]\n" +
                                  "size = [1200, 800]\n[sky]\nchecker = true\n");
    }
};

TEST_F(CompareTime, LimitsTheSizeOfThePicture) {
    const std::string command = "compare formula.toml --rounds 1 --strategy scalar --precision double --quiet ";
    const Outcome reduced = run(command + "--seconds 0.1 --json");
    ASSERT_EQ(reduced.status, 0) << reduced.err;
    const json report = json::parse(reduced.out);
    EXPECT_LT(report["width"], 1200);
    EXPECT_NEAR(report["width"].get<double>() / report["height"].get<double>(), 1.5, 0.05);
    EXPECT_EQ(report["rows"][0]["code"], KAGERO_COMPILER_BUILT ? "generated" : "interpreted");
    const Outcome text = run(command + "--seconds 0.1");
    EXPECT_NE(text.out.find("1200x800 would take too long"), std::string::npos) << text.out;
    const Outcome stated = run(command + "--size 60x40 --json");
    EXPECT_EQ(json::parse(stated.out)["width"], 60);
    for (const std::string wrong : {"--seconds -1", "--seconds x", "--seconds 5 --equal-error 0.25"}) {
        const Outcome refused = run(command + wrong);
        EXPECT_EQ(refused.status, 2) << wrong;
        EXPECT_NE(refused.err.find("--seconds"), std::string::npos) << refused.err;
    }
}

}  // namespace
}  // namespace kagero::test
