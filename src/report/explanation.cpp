#include "report/explanation.h"

#include "plan/names.h"
#include "report/formula_code.h"
#include "report/json.h"

#include <algorithm>
#include <iterator>

namespace kagero {

namespace {

/// Returns the number of characters of a UTF-8 text.
std::size_t length_of(const std::string& text) {
    return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

/// Returns the Hamiltonian, the method, and the compiler of the kernel module.
std::string kernel_text(const Plan& plan) {
    return std::string(plan.scene->space.info().name) + (plan.run.method.rescaled ? " (rescaled)" : "") + ", " +
           (plan.scene->straight ? "straight" : plan.method().name) + ", compiler " + plan.module().compiler;
}

/// Returns the decisions about features that are used, or that are not used, in the order in which `explain` prints
/// them.
std::vector<Decision> decisions_where(const Plan& plan, bool used) {
    std::vector<Decision> decisions;
    const Decisions& all = plan.decisions;
    for (const auto* group : {&all.tuning, &all.motion, &all.media, &all.ends, &all.picture})
        std::copy_if(group->begin(), group->end(), std::back_inserter(decisions),
                     [&](const Decision& decision) { return decision.used == used; });
    return decisions;
}

}  // namespace

std::string explanation_text(const Plan& plan) {
    const KernelInfo& kernel = *plan.run.kernel;
    std::string text = "kernel     " + kernel_text(plan) + "\nruns on    " + plan.module().isa + ", " +
                       name_of(kernel.strategy) + ", " + name_of(kernel.precision) + ", " +
                       std::to_string(kernel.lanes) + " rays at a time, " + std::to_string(plan.run.threads) +
                       (plan.run.threads == 1 ? " thread" : " threads") + "\n\nused\n";
    for (const Decision& decision : decisions_where(plan, true)) text += "  " + decision.feature + "\n";
    const std::vector<Decision> left_out = decisions_where(plan, false);
    std::size_t width = 0;
    for (const Decision& decision : left_out) width = std::max(width, length_of(decision.feature));
    text += "\nleft out\n";
    for (const Decision& decision : left_out)
        text += "  " + decision.feature + std::string(width - length_of(decision.feature) + 2, ' ') + decision.reason +
                "\n";
    return text;
}

std::string explanation_json(const Plan& plan) {
    Json used = Json::array(), left_out = Json::array();
    for (const Decision& decision : decisions_where(plan, true)) used.push_back(decision.feature);
    for (const Decision& decision : decisions_where(plan, false))
        left_out.push_back({{"what", decision.feature}, {"why", decision.reason}});
    const KernelInfo& kernel = *plan.run.kernel;
    Json json = {{"kernel", kernel_text(plan)},
                 {"isa", plan.module().isa},
                 {"strategy", name_of(kernel.strategy)},
                 {"precision", name_of(kernel.precision)},
                 {"lanes", kernel.lanes},
                 {"used", used},
                 {"left_out", left_out},
                 {"registers", kernel.registers},
                 {"threads", plan.run.threads},
                 {"remarks", plan.remarks},
                 {"warnings", warnings_json(warnings_of_trial(plan))}};
    add_formula_code(json, plan);
    return text_of(json);
}

std::string validity_text(const Plan& plan) {
    const SceneDescription& scene = plan.description();
    return scene.path + ": valid (" + scene.space.hamiltonian + ", " + plan.method().name + ", " +
           std::to_string(scene.objects.size()) + (scene.objects.size() == 1 ? " object, " : " objects, ") +
           std::to_string(scene.film.width) + "x" + std::to_string(scene.film.height) + ")\n";
}

std::string validity_json(const Plan& plan, const std::vector<Warning>& warnings) {
    const SceneDescription& scene = plan.description();
    return text_of({{"scene", scene.path},
                    {"valid", true},
                    {"hamiltonian", scene.space.hamiltonian},
                    {"integrator", plan.method().name},
                    {"objects", scene.objects.size()},
                    {"width", scene.film.width},
                    {"height", scene.film.height},
                    {"remarks", plan.remarks},
                    {"warnings", warnings_json(warnings)}});
}

std::string invalidity_json(const std::string& scene, const std::string& error) {
    return text_of({{"scene", scene}, {"valid", false}, {"error", error}});
}

}  // namespace kagero
