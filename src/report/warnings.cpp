#include "report/warnings.h"

#include "report/text/numbers.h"
#include "tuning/trial_run.h"

#include <algorithm>
#include <cmath>

namespace kagero {
namespace {

/// Greatest 99th percentile of the energy error, above which H counts as not conserved. A method with step control at
/// its default tolerance stays far below.
constexpr double max_energy_error = 1e-3;

/// Greatest ratio of the energy error of a formula to the tolerance of step control. A greater error is not one of
/// single steps: all stages of a step have missed a thin layer or a jump of H.
constexpr double max_energy_error_per_tolerance = 1e4;

/// Share of paths with too many bounces above which they are reported. Between parallel mirrors, some paths always end
/// in this way.
constexpr double max_cut_off_share = 0.01;

std::string count_text(std::uint64_t count, std::uint64_t rays) {
    return count == rays ? (rays == 1 ? "the ray" : "all " + std::to_string(rays) + " rays")
                         : std::to_string(count) + " of " + std::to_string(rays) + " rays";
}

std::string with_consequence(const std::string& consequence) {
    return consequence.empty() ? std::string() : " " + consequence;
}

/// Returns the settings that make steps shorter, or their errors smaller.
std::string finer_steps(const Plan& plan) {
    if (plan.method().adaptive)
        return "set integrator.tolerance to less than " + rounded(plan.run.tolerance);
    return "set integrator.step to less than " + rounded(stated_step(*plan.scene, plan.run)) +
           ", or integrator.tolerance for a method with step control";
}

Warning warning_of_failures(const Plan& plan, const RunReport& report, std::uint64_t failed,
                            const std::string& consequence) {
    const auto most = std::max_element(report.failures.begin() + 1, report.failures.end());
    const auto failure = static_cast<Failure>(most - report.failures.begin());
    std::string reason = why_failed(*plan.scene, plan.run.kernel->precision, failure);
    if (failure == Failure::not_converged)
        reason += plan.method().adaptive ? "; try another integrator.tolerance" : "; try a smaller integrator.step";
    if (*most < failed) reason += " (" + std::to_string(*most) + " of them)";
    return {"failed", count_text(failed, report.rays) + " failed" + with_consequence(consequence) + ": " + reason};
}

/// Returns the advice to use the method with angular steps that is the default for pictures of this space; "" if the
/// plan uses such a method, or if the scene does not permit it.
std::string advice_for_circling_rays(const Plan& plan) {
    const Scene& scene = *plan.scene;
    const char* wanted = scene.space.info().orbit_method;
    if (!wanted || plan.method().angular || scene.straight) return "";
    const Module& module = scene.module();
    const IntegratorInfo* const end = module.integrators + module.integrator_count;
    const IntegratorInfo* const method =
        std::find_if(module.integrators, end, [&](const auto& each) { return std::string(wanted) == each.name; });
    if (method == end || refusal_of(scene, static_cast<std::uint32_t>(method - module.integrators), false)) return "";
    return ", or integrator.method = \"" + std::string(wanted) +
           "\", whose steps are angles, so that a ray that circles the hole many times takes few of them";
}

Warning warning_of_step_limit(const Plan& plan, const RunReport& report, std::uint64_t cut_off,
                              const std::string& consequence) {
    const std::uint32_t max_steps = plan.run.max_steps;
    std::string text = count_text(cut_off, report.rays) + " did not end within integrator.max_steps = " +
                       std::to_string(max_steps) + with_consequence(consequence) + ": ";
    const double step = step_length(*plan.scene, plan.run),
                 escape_radius = plan.description().integrator.escape_radius * plan.scene->unit;
    if (step > 0 && step * max_steps < 2 * escape_radius)
        text += "these steps cover a length of " + rounded(step * max_steps) +
                ", and a path through the escape sphere has up to " + rounded(2 * escape_radius) +
                "; set integrator.max_steps to at least " + rounded(std::ceil(2 * escape_radius / step)) +
                ", or integrator.tolerance for a method with step control";
    else
        text += "set a greater integrator.max_steps" + advice_for_circling_rays(plan) +
                "; rays that are trapped, as in a duct or on a photon orbit, never end";
    return {"step_limit", text};
}

Warning warning_of_bounces(const Plan& plan, const RunReport& report, const std::string& consequence) {
    const std::string limit = std::to_string(*plan.run.max_bounces);
    return {"bounces", count_text(report.path_lengths.cut_off, report.rays) + " were cut off after " + limit +
                           " surfaces" + with_consequence(consequence) +
                           ": set a greater film.max_bounces, or --bounces for single rays"};
}

bool is_formula_with_step_control(const Plan& plan) {
    return plan.method().adaptive && plan.scene->description.space.formula && !plan.scene->straight;
}

/// Returns the 99th percentile of the energy error above which H counts as not conserved.
double energy_limit(const Plan& plan) {
    if (!is_formula_with_step_control(plan)) return max_energy_error;
    return std::min(max_energy_error, max_energy_error_per_tolerance * plan.run.tolerance);
}

Warning warning_of_energy(const Plan& plan, const RunReport& report) {
    const std::string limit = rounded(energy_limit(plan));
    std::string text = "H is not conserved: for 1 % of the rays its relative change exceeds " +
                       rounded(report.energy_error.p99) + " (more than " + limit + " is unreliable); ";
    if (is_formula_with_step_control(plan)) {
        const bool has_scale = !plan.scene->description.space.formula->length_scale.empty();
        text +=
            "the local errors of the steps are at most " + rounded(plan.run.tolerance) +
            ", so H has a layer that is thinner than the steps, or a jump, or the rays come close to a singularity; " +
            (has_scale ? "set a smaller space.length_scale there"
                       : "set space.length_scale to the thickness of the layer, as a formula that grows away from "
                         "it") +
            ", or a smaller integrator.tolerance";
    } else text += finer_steps(plan);
    return {"energy_error", text};
}

}  // namespace

std::vector<Warning> warnings_of_trial(const Plan& plan) {
    std::vector<Warning> warnings;
    if (!plan.method_trial) return warnings;
    for (const std::string& remark : plan.method_trial->remarks) warnings.push_back({"max_pixel_error", remark});
    return warnings;
}

std::vector<Warning> warnings_of(const Plan& plan, const RunReport& report, const std::string& consequence) {
    std::vector<Warning> warnings;
    const auto count = [&](Status status) { return report.counters.ended[static_cast<int>(status)]; };
    std::uint64_t failed = count(Status::failed), cut_off = count(Status::step_limit);
    const std::uint64_t long_paths = report.path_lengths.cut_off;
    cut_off -= std::min(cut_off, long_paths);
    failed -= std::min(failed, report.failures[static_cast<std::size_t>(Failure::untraced)]);
    if (failed > 0) warnings.push_back(warning_of_failures(plan, report, failed, consequence));
    if (cut_off > 0 && !std::isfinite(plan.run.parameter_limit))
        warnings.push_back(warning_of_step_limit(plan, report, cut_off, consequence));
    if (double(long_paths) > max_cut_off_share * double(report.rays))
        warnings.push_back(warning_of_bounces(plan, report, consequence));
    const bool is_confirmed = plan.method_trial && plan.method_trial->bound_met;
    if (!is_confirmed && report.energy_error.p99 > energy_limit(plan))
        warnings.push_back(warning_of_energy(plan, report));
    return warnings;
}

std::vector<Warning> warnings_of_picture(const Plan& plan, RunReport report) {
    const bool is_confirmed = plan.method_trial && plan.method_trial->bound_met;
    if (!is_confirmed && !(plan.run.outputs & output_energy)) report.energy_error = trace_trial(plan).energy_error;
    return warnings_of(plan, report, "and are black");
}

Json warnings_json(const std::vector<Warning>& warnings) {
    Json list = Json::array();
    for (const Warning& warning : warnings) list.push_back({{"key", warning.key}, {"text", warning.text}});
    return list;
}

}  // namespace kagero
