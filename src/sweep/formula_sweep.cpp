#include "sweep/formula_sweep.h"

#include "error.h"
#include "formula/nodes.h"
#include "kernels/operation.h"
#include "scene/load/load_formula.h"
#include "scene/value.h"
#include "spaces/formula_space.h"

#include <cmath>

namespace kagero {
namespace {

/// Throws an InputError that names a set and its values.
[[noreturn]] void fail_in_set(const std::vector<SweptKey>& keys, std::size_t set, const std::string& message) {
    std::string values;
    for (const SweptKey& key : keys) append_to_list(values, key.key + " = " + to_toml(key.values[set]));
    throw InputError("set " + std::to_string(set) + " of the sweep, with " + values + ": " + message);
}

/// Throws InputError if an expression without variables is not finite in a set, or if it is a step bound that is not
/// greater than 0.
void check_sets_of_formula(const FormulaDescription& formula, const std::vector<SweptKey>& keys,
                           const ParameterSets& sets) {
    const FormulaScope& scope = formula.scope;
    std::vector<double> values(scope.nodes.size());
    for (std::size_t set = 0; set < sets.count(); ++set)
        for (std::size_t i = 0; i < scope.nodes.size(); ++i) {
            const FormulaNode& n = scope.nodes[i];
            if (scope.variables[i] || n.op == Op::input) continue;
            const auto operand = [&](std::int32_t node) { return node < 0 ? 0 : values[std::size_t(node)]; };
            if (n.op == Op::constant) values[i] = n.value;
            else if (n.op == Op::parameter) values[i] = sets.parameters(set)[n.a];
            else values[i] = apply(n.op, operand(n.a), operand(n.b));
            if (!std::isfinite(values[i]))
                fail_in_set(keys, set,
                            "the value of a constant expression in " + formula.table + " is " + to_toml(values[i]) +
                                "; choose values for which all constant expressions are finite numbers");
            if (std::int32_t(i) == formula.parsed.length_scale && !(values[i] > 0))
                fail_in_set(keys, set,
                            formula.table + ".length_scale is " + to_toml(values[i]) +
                                "; choose values for which it is greater than 0");
        }
}

}  // namespace

ParameterPlan plan_with_parameters(const Plan& plan, const std::vector<SweptKey>& keys, const ParameterSets& sets) {
    const Scene& base = *plan.scene;
    if (keys.size() > max_formula_parameters)
        return {{}, "the sweep has more than " + std::to_string(max_formula_parameters) + " constants"};
    std::vector<std::string> names;
    for (const SweptKey& key : keys) names.push_back(*constant_of_key(*base.description.space.formula, key.key));
    const auto scene = std::make_shared<Scene>();
    scene->description = base.description;
    FormulaDescription& formula =
        scene->description.space.formula.emplace(with_parameters(*base.description.space.formula, names));
    if (formula.scope.has_parameter_exponent)
        return {{},
                "an exponent depends on a constant of the sweep, and a power is computed differently if its exponent "
                "is a whole number"};
    check_sets_of_formula(formula, keys, sets);
    scene->unit = base.unit;
    scene->limits = base.limits;
    scene->geometry = base.geometry;
    scene->space = {base.space.module, base.space.hamiltonian, {}};
    try {
        scene->space.parameters = compile_formula(formula, base.module(), base.description.integrator.escape_radius,
                                                  false);
    } catch (const InputError& error) {
        return {{}, error.what()};
    }
    scene->integrated.source = IntegratedHamiltonian::Source::formula;
    scene->integrated.code = compile_programs(base.module(), scene->space.parameters);
    ParameterPlan result;
    result.plan.view = plan.view;
    result.plan.run = plan.run;
    result.plan.scene = scene;
    return result;
}

}  // namespace kagero
