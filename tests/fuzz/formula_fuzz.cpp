// Fuzz target for formulas. A text must either be refused by an InputError, or be compiled to programs with which the
// start of a ray can be computed.
#include "error.h"
#include "compiler/formula_compiler.h"
#include "formula/nodes.h"
#include "formula/parser.h"
#include "modules/modules.h"
#include "spaces/formula_space.h"
#include "target.h"

#include <string>

const char* const fuzz_words =
    "x y z px py pz pt pi sqrt( exp( log( sin( cos( tan( tanh( abs( atan2( min( max( ) ( , + - * / ^ ^2 ^0.5 ^-1 "
    "r theta phi rho pr ptheta pphi prho L2 sin(theta) cos(theta) where( asin( acos( atan( sinh( cosh( "
    "^(1/3) 1e308 1e-308 0 "
    "0.5 .5 1e 1e+ (px^2+py^2+pz^2) (x*x+y*y+z*z) -- ** x^x^x ((((";

namespace {

std::uint32_t formula_index(const kagero::Module& module) {
    std::uint32_t i = 0;
    while (i < module.hamiltonian_count && std::string(module.hamiltonians[i].name) != "formula") ++i;
    return i;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace kagero;
    static const Module& module = load_module("auto");
    static const std::uint32_t space = formula_index(module);
    try {
        FormulaDescription formula;
        formula.scope = formula_scope();
        formula.energy.assign(reinterpret_cast<const char*>(data), size);
        formula.parsed.energy = parse_formula(formula.scope, {formula.energy, "space.H", {}});
        evaluate(formula.scope, formula.parsed.energy, {1, 2, 3, 0.5, -0.25, 1, -1});
        std::vector<double> programs = compile_formula(formula, module, 100, true);
        const FormulaCode code = compile_programs(module, programs);
        const double position[3] = {1, 2, 3}, direction[3] = {0, 0.6, 0.8};
        RayStart start{};
        module.start(space, programs.data(), position, direction, &start);
        return 0;
    } catch (const InputError&) {
        return -1;
    }
}
