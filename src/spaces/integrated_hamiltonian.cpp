#include "spaces/integrated_hamiltonian.h"

#include "spaces/formula_space.h"

namespace kagero {

IntegratedHamiltonian integrated_hamiltonian(const SceneDescription& scene, Space& space, bool for_comparison) {
    using Source = IntegratedHamiltonian::Source;
    const bool is_straight = space.is_straight();
    IntegratedHamiltonian h;
    if (scene.integrator.rescaling && !is_straight) {
        h.source = Source::expression;
        h.programs = compile_rescaled(scene.integrator, space, for_comparison);
    } else if (scene.space.formula) {
        h.source = Source::formula;
    } else if (for_comparison && !is_straight) {
        const bool rescaled = space.info().rescales && scene.integrator.rescale == "auto";
        h.source = rescaled ? Source::recorded_rescaled : Source::recorded;
        h.programs = record_space(space, rescaled);
    }
    if (h.has_programs()) h.code = compile_programs(*space.module, h.is_of_space() ? space.parameters : h.programs);
    return h;
}

}  // namespace kagero
