#include "report/explanation.h"

#include "report/json.h"

#include <algorithm>

namespace kagero {

namespace {

/// Characters of a text in UTF-8.
std::size_t length_of(const std::string& text) {
    return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace

std::string explanation_text(const Plan& plan, const Explanation& explanation) {
    const KernelInfo& kernel = *plan.kernel;
    std::string text = "kernel     " + explanation.kernel + "\nruns on    " + plan.module->isa + ", " + name_of(kernel.strategy) + ", " +
                       name_of(kernel.precision) + ", " + std::to_string(kernel.lanes) + " rays at a time, " +
                       std::to_string(plan.threads) + (plan.threads == 1 ? " thread" : " threads") + "\n\nused\n";
    for (const std::string& what : explanation.used) text += "  " + what + "\n";
    std::size_t width = 0;
    for (const LeftOut& part : explanation.left_out) width = std::max(width, length_of(part.what));
    text += "\nleft out\n";
    for (const LeftOut& part : explanation.left_out) text += "  " + part.what + std::string(width - length_of(part.what) + 2, ' ') + part.why + "\n";
    return text;
}

std::string explanation_json(const Plan& plan, const Explanation& explanation) {
    Json left_out = Json::array();
    for (const LeftOut& part : explanation.left_out) left_out.push_back({{"what", part.what}, {"why", part.why}});
    const Json json{{"kernel", explanation.kernel},
                                      {"isa", plan.module->isa},
                                      {"strategy", name_of(plan.kernel->strategy)},
                                      {"precision", name_of(plan.kernel->precision)},
                                      {"lanes", plan.kernel->lanes},
                                      {"used", explanation.used},
                                      {"left_out", left_out},
                                      {"registers", plan.kernel->registers},
                                      {"threads", plan.threads}};
    return text_of(json);
}

std::string validity_text(const Plan& plan) {
    const SceneDescription& scene = plan.scene;
    return scene.path + ": valid (" + scene.space.hamiltonian + ", " + scene.integrator.method + ", " + std::to_string(scene.objects.size()) +
           (scene.objects.size() == 1 ? " object, " : " objects, ") + std::to_string(scene.film.width) + "x" + std::to_string(scene.film.height) + ")\n";
}

std::string validity_json(const Plan& plan) {
    const SceneDescription& scene = plan.scene;
    return text_of({{"scene", scene.path},
                    {"valid", true},
                    {"hamiltonian", scene.space.hamiltonian},
                    {"integrator", scene.integrator.method},
                    {"objects", scene.objects.size()},
                    {"width", scene.film.width},
                    {"height", scene.film.height},
                    {"remarks", plan.remarks}});
}

std::string invalidity_json(const std::string& scene, const std::string& error) {
    return text_of({{"scene", scene}, {"valid", false}, {"error", error}});
}

}  // namespace kagero
