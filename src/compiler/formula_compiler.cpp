#include "compiler/formula_compiler.h"

#include "error.h"
#include "modules/module_files.h"

#include <chrono>
#include <cstdlib>
#include <exception>

namespace kagero {
namespace {

constexpr const char* variable = "KAGERO_FORMULA";
constexpr const char* module_name = "kagero-compiler.so";

enum class Choice { automatic, compiled, interpreted };

/// Returns the value of the environment variable.
Choice choice_of_user() {
    const char* value = std::getenv(variable);
    const std::string text = value ? value : "";
    if (text.empty() || text == "auto") return Choice::automatic;
    if (text == "compiled") return Choice::compiled;
    if (text == "interpreted") return Choice::interpreted;
    throw InputError("the environment variable " + std::string(variable) + " is '" + text +
                     "'; legal values are auto, compiled and interpreted; correct it, or unset it");
}

/// Loads the compiler module. Returns nullptr if it is not installed.
const CompilerModule* load_compiler() {
    const std::string path = module_file(module_name);
    if (path.empty()) return nullptr;
    const CompilerModule* module = reinterpret_cast<CompilerFunction>(open_module(path, "kagero_compiler"))();
    if (module->abi != code_generation_abi)
        throw RunError(path + " belongs to another version of kagero; build or install kagero again");
    return module;
}

/// Compiles the programs and makes the kernels use the machine code.
std::shared_ptr<const FunctionCompiler> generate(const CompilerModule& compiler, const Module& module,
                                                 std::vector<double>& programs) {
    std::shared_ptr<FunctionCompiler> code = compiler.create();
    module.formula_functions.describe(programs.data(), code.get(), [](void* user, const FunctionDescription* function) {
        static_cast<FunctionCompiler*>(user)->add(*function);
    });
    module.formula_functions.use(programs.data(), code->finish().data());
    return code;
}

}  // namespace

void check_formula_variable() { choice_of_user(); }

FormulaCode compile_programs(const Module& module, std::vector<double>& programs) {
    FormulaCode code;
    const Choice choice = choice_of_user();
    if (choice == Choice::interpreted) {
        code.why_interpreted = std::string(variable) + " is interpreted";
        return code;
    }
    const auto start = std::chrono::steady_clock::now();
    if (const CompilerModule* compiler = load_compiler()) {
        try {
            code.memory = generate(*compiler, module, programs);
        } catch (const std::exception& error) {
            code.why_interpreted = error.what();
        }
    } else {
        code.why_interpreted = std::string("this installation has no compiler module, ") + module_name;
    }
    code.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (choice == Choice::compiled && !code.is_compiled())
        throw InputError(std::string(variable) + " is compiled, but the formula cannot be compiled: " +
                         code.why_interpreted + "; unset the variable, or install the module");
    return code;
}

}  // namespace kagero
