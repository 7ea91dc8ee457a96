/// Report on how the programs of a formula are evaluated.
#pragma once

#include "plan/plan.h"
#include "report/json.h"

namespace kagero {

/// Adds the key `formula_code` if the scene or one of its media has a formula, or if it states an expression for the
/// time rescaling. If several formulas are not evaluated alike, the key describes one that is interpreted.
void add_formula_code(Json& json, const Plan& plan);

}  // namespace kagero
