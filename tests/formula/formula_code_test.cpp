// Tests of the choice between compiled and interpreted formulas: reports, the environment variable, equal results, and
// what formulas cannot do.
#include "tests/formula/formula_scene.h"
#include "tests/support/program.h"

#include "formula/nodes.h"
#include "formula/parser.h"

#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstring>
#include <set>

namespace kagero::test {
namespace {

using nlohmann::json;

constexpr bool module_is_built = KAGERO_COMPILER_BUILT;

/// Selects how formulas are evaluated during its life.
class FormulaVariable {
public:
    explicit FormulaVariable(const char* value) { setenv("KAGERO_FORMULA", value, 1); }
    ~FormulaVariable() { unsetenv("KAGERO_FORMULA"); }
};

/// Returns the lines of /proc/self/maps that contain a text.
int mappings_with(const std::string& text) {
    std::ifstream maps("/proc/self/maps");
    int count = 0;
    for (std::string line; std::getline(maps, line);) count += line.find(text) != std::string::npos;
    return count;
}

// This test is the first one of the file, so that no other test has loaded the module. Each test is a process in ctest.
TEST(FormulaCode, ModuleIsLoadedOnlyForFormulas) {
    plan_of_file(scene_file("room.toml"), {}, {}, false);
    EXPECT_EQ(mappings_with("kagero-compiler"), 0);
    if (!module_is_built) GTEST_SKIP() << "the compiler module is not built";
    plan_of_text(straight_space + view_text, {}, {}, false);
    EXPECT_GT(mappings_with("kagero-compiler"), 0);
}

TEST(FormulaCode, RaysHaveTheSameBits) {
    if (!module_is_built) GTEST_SKIP() << "the compiler module is not built";
    const std::string tail = "[integrator]\nescape_radius = 3\nmax_steps = 300\n";
    for (const char* strategy : {"packet", "scalar"})
        for (const char* method : {"gauss8", "verlet", "dp85", "srkn6"})
            for (const std::string& isa : find_isa_names("all")) {
                const auto ends_with = [&](const char* choice) {
                    const FormulaVariable variable(choice);
                    return traced(mirage_formula + tail,
                                  {{std::string("integrator.method=\"") + method + "\""},
                                   {"integrator.rescale=\"1/n\""}},
                                  strategy, fan({0, 0, 0}), isa);
                };
                const std::vector<RayEnd> a = ends_with("interpreted"), b = ends_with("compiled");
                ASSERT_EQ(a.size(), b.size());
                for (std::size_t i = 0; i < a.size(); ++i)
                    EXPECT_TRUE(std::memcmp(a[i].q, b[i].q, sizeof a[i].q) == 0 &&
                                std::memcmp(a[i].p, b[i].p, sizeof a[i].p) == 0 && a[i].steps == b[i].steps &&
                                a[i].gradients == b[i].gradients && a[i].status == b[i].status)
                        << strategy << ' ' << method << ' ' << isa << ", ray " << i;
            }
}

// Formulas consist of numbers, names of the scene, and functions of the operation table. The compiler receives only the
// nodes of a parsed formula.
TEST(FormulaCode, FormulasCannotNameAnythingElse) {
    const auto load_with = [](const std::string& attempt) {
        const std::string space =
            "[space]\nhamiltonian = \"formula\"\nH = '''0.5*(px^2 + py^2 + pz^2 - 1) + 0*(" + attempt + ")'''\n";
        plan_of_text(space + view_text, {}, {}, false);
    };
    EXPECT_NO_THROW(load_with("sin(x)"));
    for (const char* attempt : {"system(1)",
                                "exec(x)",
                                "fopen(x)",
                                "dlsym(x)",
                                "puts(x)",
                                "malloc(x)",
                                "abort()",
                                "errno",
                                "stdout",
                                "main",
                                "_exit(1)",
                                "__builtin_trap()",
                                "getenv(x)",
                                "asm(x)",
                                "`ls`",
                                "$(ls)",
                                "x; ls",
                                "x | ls",
                                "x > file",
                                "\\u0022",
                                "#include",
                                "/etc/passwd",
                                "file:///etc",
                                "*x",
                                "&x",
                                "x[0]",
                                "x.y",
                                "x->y",
                                "{x}",
                                "'ls'",
                                "libc.so.6",
                                "kagero_compiler(x)",
                                "0x7fffffff(x)",
                                "(x)(y)",
                                "sin",
                                "sin sin(x)",
                                "import os",
                                "%n"})
        EXPECT_THROW(load_with(attempt), InputError) << attempt;
}

/// Returns the names that the shared libraries of this process export, from the lists of the tool nm.
std::set<std::string> exported_names() {
    std::set<std::string> libraries, names;
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);)
        if (const std::size_t path = line.find('/'); path != std::string::npos && line.find(".so") != std::string::npos)
            libraries.insert(line.substr(path));
    for (const std::string& library : libraries) {
        FILE* list = popen(("nm -D --defined-only -P '" + library + "' 2>/dev/null").c_str(), "r");
        char name[4096];
        while (list && std::fscanf(list, "%4095s%*[^\n]", name) == 1) {
            const std::string symbol = name;
            names.insert(symbol.substr(0, symbol.find('@')));
        }
        if (list) pclose(list);
    }
    return names;
}

// A formula can call only the functions of the operation table, whatever the libraries of the process export.
TEST(FormulaCode, FormulasCannotCallFunctionsOfLibraries) {
    const std::set<std::string> names = exported_names(),
                                functions{"sqrt", "exp",  "log", "sin",  "cos",  "tan",  "tanh", "atan2", "abs",
                                          "min",  "max",  "atan", "asin", "acos", "sinh", "cosh"};
    if (names.empty()) GTEST_SKIP() << "the tool nm is not installed";
    for (const char* expected : {"system", "fopen", "dlopen", "execve", "sin"}) EXPECT_TRUE(names.contains(expected));
    int refused = 0;
    for (const std::string& name : names)
        for (const std::string& formula : {name, name + "(x)", name + "(x, y)", name + "(x, y, z)"}) {
            FormulaScope scope = formula_scope();
            try {
                parse_formula(scope, {formula, "space.H", {}});
                EXPECT_TRUE(functions.contains(name)) << formula;
            } catch (const InputError&) {
                ++refused;
            }
        }
    EXPECT_GT(refused, 10000);
}

class FormulaCodeReport : public ProgramTest {
protected:
    void SetUp() override {
        ProgramTest::SetUp();
        write("formula.toml", straight_space + view_text);
    }
    json explained(const std::string& prefix) const {
        const Outcome outcome = run("explain formula.toml --json", prefix);
        EXPECT_EQ(outcome.status, 0) << outcome.err;
        return json::parse(outcome.out);
    }
};

TEST_F(FormulaCodeReport, StatesHowFormulasAreEvaluated) {
    const json interpreted = explained("KAGERO_FORMULA=interpreted");
    EXPECT_EQ(interpreted["formula_code"]["kind"], "interpreted");
    EXPECT_EQ(interpreted["formula_code"]["reason"], "KAGERO_FORMULA is interpreted");
    EXPECT_NE(interpreted["used"].dump().find("interpreter of H: "), std::string::npos);
    if (!module_is_built) GTEST_SKIP() << "the compiler module is not built";
    for (const char* prefix : {"", "KAGERO_FORMULA=", "KAGERO_FORMULA=auto", "KAGERO_FORMULA=compiled"}) {
        const json compiled = explained(prefix);
        EXPECT_EQ(compiled["formula_code"]["kind"], "compiled") << prefix;
        EXPECT_GE(compiled["formula_code"]["compile_s"].get<double>(), 0);
        EXPECT_NE(compiled["used"].dump().find("machine code for H"), std::string::npos);
    }
    const Outcome render = run("render formula.toml -o a.png --json");
    EXPECT_EQ(json::parse(render.out)["formula_code"]["kind"], "compiled");
}

TEST_F(FormulaCodeReport, RefusesOtherValuesOfTheVariable) {
    const Outcome outcome = run("explain formula.toml", "KAGERO_FORMULA=fast");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_EQ(outcome.err,
              "kagero: error: the environment variable KAGERO_FORMULA is 'fast'; legal values are auto, compiled and "
              "interpreted; correct it, or unset it\n");
}

// An installation without the module interprets formulas, unless the variable demands machine code.
TEST_F(FormulaCodeReport, WithoutTheModuleFormulasAreInterpreted) {
    namespace fs = std::filesystem;
    fs::create_directories(directory_ / "bin");
    fs::create_directories(directory_ / "lib/kagero");
    fs::copy_file(KAGERO_BINARY, directory_ / "bin/kagero");
    for (const IsaInfo& isa : find_isas())
        fs::copy_file(isa.path, directory_ / "lib/kagero" / fs::path(isa.path).filename());
    const std::string program = (directory_ / "bin/kagero").string();
    const Outcome outcome = run_program(program, "explain formula.toml --json");
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(json::parse(outcome.out)["formula_code"]["reason"],
              "this installation has no compiler module, kagero-compiler.so");
    const Outcome demanded = run_program(program, "explain formula.toml", "KAGERO_FORMULA=compiled");
    EXPECT_EQ(demanded.status, 2);
    EXPECT_NE(demanded.err.find("this installation has no compiler module"), std::string::npos) << demanded.err;
}

}  // namespace
}  // namespace kagero::test
