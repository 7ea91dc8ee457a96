#include "study/compare/compared_plans.h"

#include "error.h"

#include <algorithm>

namespace kagero {
namespace {

/// Returns true if the module contains kernels of the form `gradient` for the space of the plan. It then contains all
/// kernels that exist for comparison.
bool has_compared_kernels(const Plan& plan) {
    const Module& module = plan.module();
    return std::any_of(module.kernels, module.kernels + module.kernel_count, [&](const KernelInfo& kernel) {
        return kernel.form == Form::gradient && !refusal_of(*plan.scene, kernel, plan.run.method);
    });
}

}  // namespace

HamiltonianCode code_of(const Scene& scene) {
    if (!scene.integrated.has_programs()) return HamiltonianCode::built_in;
    return scene.integrated.code.is_compiled() ? HamiltonianCode::generated : HamiltonianCode::interpreted;
}

bool can_supplement(const KernelInfo& kernel) {
    return kernel.form != Form::gang && kernel.form != Form::auto_vectorized;
}

std::vector<ComparedPlan> plans_for_comparison(SceneDescription scene, Options options,
                                               std::vector<std::array<std::string, 2>>& left_out) {
    scene.integrator.lanes = 0;
    const Plan plan = make_plan(scene, options);
    std::vector<ComparedPlan> plans{{plan}};
    const bool has_programs = code_of(*plan.scene) != HamiltonianCode::built_in;
    if (plan.scene->straight || (!has_programs && has_compared_kernels(plan))) return plans;
    const auto leave_out = [&](const std::string& why) {
        left_out.push_back({options.isa + " kernels with machine code of H", why});
    };
    options.for_comparison = true;
    try {
        const auto with_code = make_scene(std::move(scene), options, Purpose::picture, plan.scene.get());
        if (!has_programs && !with_code->integrated.code.is_compiled()) {
            leave_out(with_code->integrated.code.why_interpreted);
            return plans;
        }
        if (!has_programs) plans.push_back({plan, true});
        plans.back().plan.scene = with_code;
    } catch (const InputError& error) {  // the programs are too large
        leave_out(error.what());
    }
    return plans;
}

std::string why_unsupported(const Plan& plan, const KernelInfo& kernel, const std::string& method) {
    const Module& module = plan.module();
    const auto position = std::find_if(module.integrators, module.integrators + module.integrator_count,
                                       [&](const IntegratorInfo& info) { return method == info.name; });
    const auto integrator = static_cast<std::uint32_t>(position - module.integrators);
    const bool rescaled = plan.run.method.rescaled;
    if (const char* why = refusal_of(*plan.scene, integrator, rescaled)) return why;
    const char* why = refusal_of(*plan.scene, kernel, {integrator, rescaled});
    return why ? why : "it does not support the method";
}

}  // namespace kagero
