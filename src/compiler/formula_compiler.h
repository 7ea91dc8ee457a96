/// Compilation of a formula's programs to machine code. The compiler module (compiler/asmjit) implements it. It is a
/// separate shared library, so that a run without formulas neither needs nor loads it.
#pragma once

#include "kernels/code_generation.h"

#include <memory>
#include <string>
#include <vector>

namespace kagero {

/// Generates machine code for functions and owns its memory, which is never writable and executable at the same time.
class FunctionCompiler {
public:
    virtual ~FunctionCompiler() = default;
    /// Generates code for a function.
    virtual void add(const FunctionDescription& function) = 0;
    /// Makes the code executable and returns the addresses of the functions in the order of `add`. Call it once.
    virtual std::vector<CompiledFunction> finish() = 0;
};

/// The functions of the compiler module.
struct CompilerModule {
    std::uint32_t abi;  ///< The value of code_generation_abi with which the module was compiled.
    /// Returns a compiler, or nullptr if there is not enough memory.
    std::unique_ptr<FunctionCompiler> (*create)();
};
/// Type of the function `kagero_compiler`, which the module exports.
using CompilerFunction = const CompilerModule* (*)();

/// How the programs of a formula are evaluated.
struct FormulaCode {
    std::shared_ptr<const FunctionCompiler> memory;  ///< Owner of the machine code; null if there is none.
    std::string why_interpreted;                     ///< Why the programs are interpreted; empty if they are compiled.
    double seconds = 0;                              ///< Time of the compilation.

    bool is_compiled() const { return memory != nullptr; }
};

/// Throws InputError if the environment variable KAGERO_FORMULA has a value that is not legal.
void check_formula_variable();

/// Compiles programs that Module::compile has written, if possible. The environment variable KAGERO_FORMULA selects
/// `compiled` or `interpreted`; by default, programs are compiled if the compiler module is installed. Throws
/// InputError if the variable has another value, or if it is `compiled` and the programs cannot be compiled.
FormulaCode compile_programs(const Module& module, std::vector<double>& programs);

}  // namespace kagero
