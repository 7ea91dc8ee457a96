/// The Hamiltonian that the kernels integrate: that of the space, or programs made from it.
#pragma once

#include "compiler/formula_compiler.h"
#include "modules/space.h"
#include "scene/description.h"

namespace kagero {

/// The Hamiltonian that the kernels integrate, and how they evaluate it.
struct IntegratedHamiltonian {
    enum class Source {
        compiled,          ///< The H of a built-in space, which is compiled with kagero.
        formula,           ///< The H of a formula. Its programs are the parameters of the space.
        expression,        ///< Ω(H − H0) with an Ω that the scene states as an expression.
        recorded,          ///< A compiled H that was recorded as programs, with Options::for_comparison.
        recorded_rescaled  ///< The same, multiplied by the Ω of the space.
    };
    Source source = Source::compiled;
    std::vector<double> programs;  ///< The programs, unless the space contains the Hamiltonian.
    FormulaCode code;              ///< How programs are evaluated.

    /// Returns true if the Hamiltonian consists of programs, which are generated or interpreted.
    bool has_programs() const { return source != Source::compiled; }
    /// Returns true if the Hamiltonian is that of the space, and not made from it.
    bool is_of_space() const { return source <= Source::formula; }
};

/// Returns the integrated Hamiltonian of a scene in which this is the space, and generates code for its programs. With
/// `for_comparison`, it consists of programs also if that of the space is compiled and its rays are bent. Throws
/// InputError if the programs are too large.
IntegratedHamiltonian integrated_hamiltonian(const SceneDescription& scene, Space& space, bool for_comparison);

}  // namespace kagero
