#include "report/explanation.h"

#include "plan/names.h"
#include "report/json.h"

#include <algorithm>
#include <iterator>

namespace kagero {

namespace {

/// Characters of a text in UTF-8.
std::size_t length_of(const std::string& text) {
    return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

/// What the kernel module was compiled with, and for which Hamiltonian and method.
std::string kernel_text(const Plan& plan) {
    return std::string(plan.scene->space.info().name) + (plan.run.method.rescaled ? " (rescaled)" : "") + ", " +
           (plan.scene->straight ? "straight" : plan.method().name) + ", compiler " + plan.module().compiler;
}

/// The decisions that were taken, or those that were not, in order.
std::vector<Decision> decisions_where(const Plan& plan, bool taken) {
    std::vector<Decision> chosen;
    const Decisions& all = plan.decisions;
    for (const auto* group : {&all.tuning, &all.motion, &all.ends, &all.picture})
        std::copy_if(group->begin(), group->end(), std::back_inserter(chosen),
                     [&](const Decision& one) { return one.taken == taken; });
    return chosen;
}

}  // namespace

std::string explanation_text(const Plan& plan) {
    const KernelInfo& kernel = *plan.run.kernel;
    std::string text = "kernel     " + kernel_text(plan) + "\nruns on    " + plan.module().isa + ", " +
                       name_of(kernel.strategy) + ", " + name_of(kernel.precision) + ", " +
                       std::to_string(kernel.lanes) + " rays at a time, " + std::to_string(plan.run.threads) +
                       (plan.run.threads == 1 ? " thread" : " threads") + "\n\nused\n";
    for (const Decision& used : decisions_where(plan, true)) text += "  " + used.what + "\n";
    const std::vector<Decision> left_out = decisions_where(plan, false);
    std::size_t width = 0;
    for (const Decision& part : left_out) width = std::max(width, length_of(part.what));
    text += "\nleft out\n";
    for (const Decision& part : left_out)
        text += "  " + part.what + std::string(width - length_of(part.what) + 2, ' ') + part.why_not + "\n";
    return text;
}

std::string explanation_json(const Plan& plan) {
    Json used = Json::array(), left_out = Json::array();
    for (const Decision& part : decisions_where(plan, true)) used.push_back(part.what);
    for (const Decision& part : decisions_where(plan, false))
        left_out.push_back({{"what", part.what}, {"why", part.why_not}});
    const KernelInfo& kernel = *plan.run.kernel;
    return text_of({{"kernel", kernel_text(plan)},
                    {"isa", plan.module().isa},
                    {"strategy", name_of(kernel.strategy)},
                    {"precision", name_of(kernel.precision)},
                    {"lanes", kernel.lanes},
                    {"used", used},
                    {"left_out", left_out},
                    {"registers", kernel.registers},
                    {"threads", plan.run.threads}});
}

std::string validity_text(const Plan& plan) {
    const SceneDescription& scene = plan.description();
    return scene.path + ": valid (" + scene.space.hamiltonian + ", " + plan.method().name + ", " +
           std::to_string(scene.objects.size()) + (scene.objects.size() == 1 ? " object, " : " objects, ") +
           std::to_string(scene.film.width) + "x" + std::to_string(scene.film.height) + ")\n";
}

std::string validity_json(const Plan& plan) {
    const SceneDescription& scene = plan.description();
    return text_of({{"scene", scene.path},
                    {"valid", true},
                    {"hamiltonian", scene.space.hamiltonian},
                    {"integrator", plan.method().name},
                    {"objects", scene.objects.size()},
                    {"width", scene.film.width},
                    {"height", scene.film.height},
                    {"remarks", plan.remarks}});
}

std::string invalidity_json(const std::string& scene, const std::string& error) {
    return text_of({{"scene", scene}, {"valid", false}, {"error", error}});
}

}  // namespace kagero
