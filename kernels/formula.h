/// Formulas of scenes, as the program passes them to kernel modules. `kernels/abi.h` includes this file.
#pragma once

#include <cstdint>

namespace kagero {

enum class Op : std::uint8_t;  // kernels/operation.h
/// An operation of a formula. Operands are indices of earlier nodes. `a` of an input indexes (x y z px py pz pt), and
/// `a` of a parameter is its number.
struct FormulaNode {
    Op op;
    std::int32_t a, b;
    double value;  ///< Value of a constant, or of a parameter in one set of parameters.
};

/// A Hamiltonian that is written in a scene. Its expressions are indices into one list of nodes; −1: absent. If
/// `energy` is −1, only `rescale` or `declared_rescaling` may be stated, and everything else is that of the compiled
/// Hamiltonian `hamiltonian`.
struct Formula {
    const FormulaNode* nodes;
    std::uint32_t node_count;
    std::int32_t energy;
    std::int32_t domain, capture;  ///< A ray escapes where `domain` ≤ 0; it is captured where `capture` ≤ 0.
    std::int32_t length_scale;     ///< The step bound.
    std::int32_t rescale;          ///< Ω(q): Ω·(H − H0) is integrated.
    std::int32_t parts[2];         ///< H_A and H_B with H = H_A + H_B; both are stated, or neither.
    double level;                  ///< H0.
    double pt;
    /// For each node with branches (see `has_branches`): the typical magnitude of the argument whose sign selects the
    /// branch, or of the difference of the arguments; null: 1.
    const double* branch_magnitudes = nullptr;
    std::uint32_t hamiltonian = 0;       ///< If `energy` is −1: an index into Module::hamiltonians.
    const double* parameters = nullptr;  ///< If `energy` is −1: the parameters of that Hamiltonian.
    /// Number of parameters in the nodes. Only Module::sweep_kernel traces rays of a formula with parameters.
    std::uint32_t parameter_count = 0;
    bool declared_rescaling = false;     ///< If `energy` is −1: Ω is that of the compiled Hamiltonian.
    bool for_comparison = false;         ///< The programs are also needed by the kernels that exist for comparison.
};
inline constexpr std::uint32_t max_formula_nodes = 4096;     ///< Greatest number of nodes.
inline constexpr std::uint32_t max_formula_parameters = 16;  ///< Greatest number of parameters.

struct FunctionDescription;  // kernels/code_generation.h
/// Receives the functions of a formula one after the other. `user` is the argument of FormulaFunctions::describe.
using FunctionSink = void (*)(void* user, const FunctionDescription*);
/// Machine code of a program. It evaluates the program at `points` ≥ 1 points. `in` contains the inputs of the first
/// point, then those of the second point, and so on; so does `out` for the outputs. Each input and output is a value of
/// the type for which the code was generated. `in` and `out` do not overlap.
using CompiledFunction = void (*)(const void* in, void* out, std::uint64_t points);

/// The functions of a kernel module for the compilation of programs that Module::compile has written.
struct FormulaFunctions {
    /// Passes every function that can be compiled to `sink`, in an order that depends only on the programs. Functions
    /// of kernels that exist for comparison are passed only if Formula::for_comparison was set.
    void (*describe)(const double* programs, void* user, FunctionSink sink);
    /// Replaces the interpreter of these programs by compiled functions, which have the order of `describe`.
    void (*use)(double* programs, const CompiledFunction* functions);
    /// Sets the values of the parameters with which starts of rays and rest frames are computed.
    void (*set_parameters)(double* programs, const double* values);
};

}  // namespace kagero
