#include "report/formula_code.h"

namespace kagero {
namespace {

/// Returns the code of the scene or of a medium: preferably one that is interpreted; nullptr if there is none.
const FormulaCode* formula_code_of(const Scene& scene) {
    const FormulaCode* found = nullptr;
    const auto consider = [&](const FormulaCode& code) {
        const bool is_interpreted = !code.why_interpreted.empty();
        if (is_interpreted || (code.is_compiled() && !found)) found = &code;
    };
    consider(scene.integrated.code);
    for (const auto& medium : scene.media) consider(medium->integrated.code);
    return found;
}

}  // namespace

void add_formula_code(Json& json, const Plan& plan) {
    const FormulaCode* code = formula_code_of(*plan.scene);
    if (!code) return;
    Json& entry = json["formula_code"];
    entry["kind"] = code->is_compiled() ? "compiled" : "interpreted";
    if (code->is_compiled()) entry["compile_s"] = code->seconds;
    else entry["reason"] = code->why_interpreted;
}

}  // namespace kagero
