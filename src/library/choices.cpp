#include "library/choices.h"

#include "error.h"
#include "modules/modules.h"
#include "plan/names.h"
#include "report/explanation.h"
#include "report/warnings.h"
#include "scene/load/load.h"

namespace kagero {
namespace {

/// Returns the value of an option, or nullopt for "auto". Throws InputError if the name is unknown.
template <class Value>
std::optional<Value> parse_choice(const char* option, const std::string& name, const char* legal,
                                  std::optional<Value> (*find)(const std::string&)) {
    const std::optional<Value> value = find(name);
    if (!value && name != "auto")
        throw InputError(std::string(option) + ": unknown value \"" + name + "\"; legal values: auto, " + legal);
    return value;
}

}  // namespace

Options options_of(const RunOptions& requested) {
    Options options;
    require_isa("isa", requested.isa);
    options.isa = requested.isa;
    options.strategy = parse_choice("strategy", requested.strategy, "scalar, per-ray, packet", strategy_named);
    options.precision = parse_choice("precision", requested.precision, "double, float", precision_named);
    options.threads = requested.threads;
    return options;
}

SceneDescription description_of(const SceneSource& source, const Options& options, SceneUse use) {
    return load_scene_text(source.text ? *source.text : scene_text(source.file), source.file,
                           {source.overrides.begin(), source.overrides.end()}, catalogue(options.isa), use);
}

RunChoices run_choices_of(const Plan& plan) {
    const KernelInfo& kernel = *plan.run.kernel;
    RunChoices choices;
    choices.hamiltonian = plan.description().space.hamiltonian;
    choices.integrator = plan.method().name;
    choices.isa = plan.module().isa;
    choices.strategy = name_of(kernel.strategy);
    choices.precision = name_of(kernel.precision);
    choices.lanes = kernel.lanes;
    choices.threads = plan.run.threads;
    choices.step = stated_step(*plan.scene, plan.run);
    if (const auto& trial = plan.method_trial) {
        choices.max_pixel_error = trial->bound;
        choices.estimated_error = trial->estimate;
        choices.bound_is_met = trial->bound_met;
    }
    choices.remarks = plan.remarks;
    for (const Warning& warning : warnings_of_trial(plan)) choices.remarks.push_back(warning.text);
    choices.explanation = explanation_text(plan);
    return choices;
}

}  // namespace kagero
