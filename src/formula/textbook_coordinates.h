/// Replaces the textbook variables r theta phi rho pr ptheta pphi prho L2 of a formula by expressions in x y z px py
/// pz.
#pragma once

#include "formula/formula.h"

namespace kagero {

/// Returns a node that equals `node` and contains no textbook variable.
///
/// sin θ = ρ/r, cos θ = z/r and tan θ = ρ/z need no angle. A formula from a textbook can be regular on the axis
/// although its terms are not: in pθ² + pφ²/sin²θ = L², both terms depend on the direction from which the axis is
/// approached. Sums with such terms are expanded as far as necessary, pθ² is replaced by L² − pφ²/sin²θ, and terms that
/// cancel are removed. If a singular term remains, the sum is left as it is.
std::int32_t to_cartesian(FormulaScope& scope, std::int32_t node);

}  // namespace kagero
