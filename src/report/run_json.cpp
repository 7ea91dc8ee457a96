#include "report/run_json.h"

#include "accuracy/timing.h"
#include "error.h"
#include "film/standard_error.h"
#include "plan/names.h"
#include "render/operation_count.h"
#include "report/formula_code.h"
#include "report/json.h"
#include "report/text/numbers.h"
#include "report/thread_shares.h"

#include <algorithm>
#include <cmath>

namespace kagero {

namespace {

/// Returns the occupancy active / issued; null if `issued` is 0.
Json occupancy_json(std::uint64_t active, std::uint64_t issued) {
    return issued == 0 ? Json() : Json(static_cast<double>(active) / static_cast<double>(issued));
}

/// Returns true if the method controls its step by a tolerance.
bool is_adaptive(const Plan& plan) { return plan.method().adaptive; }

Json status_json(const RunReport& report) {
    Json counts;
    for (std::uint32_t s = 0; s < status_count; ++s) counts[name_of(static_cast<Status>(s))] = report.counters.ended[s];
    return counts;
}

void add_kernel(Json& json, const Plan& plan) {
    json["isa"] = plan.module().isa;
    json["strategy"] = name_of(plan.run.kernel->strategy);
    json["precision"] = name_of(plan.run.kernel->precision);
    json["lanes"] = plan.run.kernel->lanes;
    if (plan.run.kernel->form != Form::none) json["form"] = name_of(plan.run.kernel->form);
    add_formula_code(json, plan);
}

Json energy_json(const Plan& plan, const RunReport& report) {
    if (!(plan.run.outputs & output_energy)) return {};
    return {{"p50", report.energy_error.p50}, {"p99", report.energy_error.p99}, {"max", report.energy_error.max}};
}

/// Adds the numbers of surfaces that have sent rays on, and the work for each generation of rays.
void add_bounces(Json& json, const RunReport& report) {
    if (report.generations.empty()) return;
    const PathLengths& lengths = report.path_lengths;
    json["bounces"] = {{"mean", ratio(static_cast<double>(lengths.bounces), static_cast<double>(report.rays))},
                       {"max", lengths.greatest},
                       {"cut_off", lengths.cut_off}};
    json["generations"] = Json::array();
    for (const GenerationCount& generation : report.generations)
        json["generations"].push_back(
            {{"rays", generation.rays},
             {"lane_occupancy", occupancy_json(generation.active_lane_steps, generation.issued_lane_steps)},
             {"ns_per_ray", ratio(static_cast<double>(generation.nanoseconds), static_cast<double>(generation.rays))}});
}

/// Adds the share of the pixels that were traced, and the errors of the other pixels.
void add_interpolation(Json& json, const RunReport& report) {
    json["traced_share"] = report.pixels > 0 ? 1 - ratio(double(report.interpolated_pixels), double(report.pixels)) : 1;
    if (report.interpolated_pixels > 0)
        json["interpolation_error"] = {{"p99", report.interpolation_error.p99},
                                       {"max", report.interpolation_error.max}};
}

Json ranks_json(const RunReport& report) {
    Json ranks = Json::array();
    for (const RankTime& rank : report.ranks)
        ranks.push_back({{"host", rank.host},
                         {"threads", rank.threads},
                         {"tiles", rank.tiles},
                         {"seconds", rank.seconds},
                         {"busy_s", rank.busy}});
    return ranks;
}

double nanoseconds_per_ray(const RunReport& run) { return ratio(1e9 * run.seconds, static_cast<double>(run.rays)); }

Json timing_json(const std::vector<RunReport>& runs) {
    std::vector<double> times;
    for (const RunReport& run : runs) times.push_back(nanoseconds_per_ray(run));
    const Timing timing = timing_of(times);
    return {{"median", timing.median}, {"min", timing.min}, {"max", timing.max}};
}

/// Returns one number of every ray end, in the order of the rays.
Json integrals_of_ends(const std::vector<RayEnd>& ends, double RayEnd::*number) {
    Json numbers = Json::array();
    for (const RayEnd& end : ends) numbers.push_back(end.*number);
    return numbers;
}

/// Returns a number, or null if it is NaN.
Json number_or_null(double number) { return std::isnan(number) ? Json() : Json(number); }

/// Returns the summary of the layer `standard_error`. Numbers that are not known are null.
Json standard_error_json(const Film& film) {
    const StandardError summary = summarize_standard_error(film);
    return {{"rms", number_or_null(summary.rms)},
            {"max", number_or_null(summary.max)},
            {"relative", number_or_null(summary.relative)}};
}

}  // namespace

std::string render_json(const Plan& plan, const RunReport& report, const Film* film, double write_seconds,
                        std::vector<Warning> warnings) {
    const std::vector<Warning> of_trial = warnings_of_trial(plan);
    warnings.insert(warnings.begin(), of_trial.begin(), of_trial.end());
    const Tile& window = plan.view.window;
    const Counters& work = report.counters;
    Json json;
    json["scene"] = plan.description().path;
    add_kernel(json, plan);
    json["threads"] = plan.run.threads;
    json["width"] = window.x1 - window.x0;
    json["height"] = window.y1 - window.y0;
    json["rays"] = report.rays;
    json["seconds"] = report.seconds;
    json["mrays_per_s"] = ratio(static_cast<double>(report.rays - report.earlier_rays), 1e6 * report.seconds);
    json["steps"] = work.steps;
    json["gradients"] = work.gradients;
    json["queries"] = work.queries;
    json["lane_occupancy"] = occupancy_json(work.active_lane_steps, work.issued_lane_steps);
    json["status"] = status_json(report);
    add_bounces(json, report);
    add_interpolation(json, report);
    if (film && film->has("standard_error")) json["standard_error"] = standard_error_json(*film);
    json["energy_error"] = energy_json(plan, report);
    json["iteration_occupancy"] = occupancy_json(work.active_iterations, work.issued_iterations);
    const auto vectorized = vectorization_ratio(plan, report);
    json["vectorization_ratio"] = vectorized ? Json(*vectorized) : Json();
    json["load_s"] = plan.load_seconds;
    json["write_s"] = write_seconds;
    if (report.earlier_rays > 0) json["earlier_rays"] = report.earlier_rays;
    json["hamiltonian"] = plan.description().space.hamiltonian;
    json["integrator"] = plan.method().name;
    json["step"] = stated_step(*plan.scene, plan.run);
    if (is_adaptive(plan)) json["tolerance"] = plan.run.tolerance;
    if (plan.run.solver_tolerance > 0) json["solver_tolerance"] = plan.run.solver_tolerance;
    json["registers"] = plan.run.kernel->registers;
    json["compiler"] = plan.module().compiler;
    json["straight"] = plan.scene->straight;
    json["unrefined"] = report.counters.unrefined;
    if (plan.method_trial) {
        json["max_pixel_error"] = plan.method_trial->bound;
        json["pixel_error_estimate"] = plan.method_trial->bound_met ? Json(plan.method_trial->estimate) : Json();
        json["pixel_error_ill_conditioned"] = plan.method_trial->ill_conditioned_share;
    }
    json["interrupted"] = report.interrupted;
    json["out_of_time"] = report.out_of_time;
    json["schedule"] = name_of(report.schedule);
    json["predict_s"] = report.predict_seconds;
    json["thread_times"] = threads_json(report);
    if (!report.ranks.empty()) json["ranks"] = ranks_json(report);
    json["warnings"] = warnings_json(warnings);
    json["remarks"] = plan.remarks;
    return text_of(json);
}

std::string trace_json(const Plan& plan, const std::vector<RunReport>& runs, const std::vector<RayEnd>& ends,
                       const std::vector<Warning>& warnings) {
    const RunReport& last = runs.back();
    const double rays = static_cast<double>(last.rays);
    Json json;
    json["rays"] = last.rays;
    json["threads"] = plan.run.threads;
    add_kernel(json, plan);
    json["ns_per_ray"] = timing_json(runs);
    json["steps_per_ray"] = ratio(static_cast<double>(last.counters.steps), rays);
    json["gradients_per_ray"] = ratio(static_cast<double>(last.counters.gradients), rays);
    json["lane_occupancy"] = occupancy_json(last.counters.active_lane_steps, last.counters.issued_lane_steps);
    json["status"] = status_json(last);
    add_bounces(json, last);
    json["iteration_occupancy"] = occupancy_json(last.counters.active_iterations, last.counters.issued_iterations);
    json["repetitions"] = runs.size();
    if (plan.run.outputs & output_action) json["action"] = integrals_of_ends(ends, &RayEnd::action);
    if (plan.run.outputs & output_time) json["time"] = integrals_of_ends(ends, &RayEnd::time);
    json["warnings"] = warnings_json(warnings);
    json["remarks"] = plan.remarks;
    return text_of(json);
}

Json counts_json(const RunReport& report) {
    const Counters& work = report.counters;
    Json json;
    json["rays"] = report.rays;
    json["steps"] = work.steps;
    json["gradients"] = work.gradients;
    json["queries"] = work.queries;
    json["lane_occupancy"] = occupancy_json(work.active_lane_steps, work.issued_lane_steps);
    json["status"] = status_json(report);
    add_bounces(json, report);
    add_interpolation(json, report);
    if (report.energy_error.p50 >= 0)  // NaN if no ray has an error
        json["energy_error"] = {
            {"p50", report.energy_error.p50}, {"p99", report.energy_error.p99}, {"max", report.energy_error.max}};
    json["iteration_occupancy"] = occupancy_json(work.active_iterations, work.issued_iterations);
    json["unrefined"] = work.unrefined;
    json["interrupted"] = report.interrupted;
    return json;
}

Metadata picture_metadata(const Plan& plan, const RunReport& report) {
    Metadata metadata = plan_metadata(plan);
    const Metadata of_run = run_metadata(report);
    metadata.insert(metadata.end(), of_run.begin(), of_run.end());
    return metadata;
}

Metadata plan_metadata(const Plan& plan) {
    const SceneDescription& scene = plan.description();
    const HamiltonianInfo& space = plan.scene->space.info();
    std::string overrides;
    for (const std::string& text : scene.overrides) overrides += text + "\n";
    Metadata metadata{
        {"version", KAGERO_VERSION},
        {"scene", scene.text},
        {"overrides", overrides},
        {"isa", plan.module().isa},
        {"strategy", name_of(plan.run.kernel->strategy)},
        {"precision", name_of(plan.run.kernel->precision)},
        {"hamiltonian", space.formula},
        {"integrator", plan.method().name},
        {"step", shortest(stated_step(*plan.scene, plan.run))},
        {"seed", std::to_string(scene.film.seed)},
        {"credits", space.source},
    };
    if (scene.animation && !scene.animation->values.empty()) {
        std::string values;
        for (const auto& [key, value] : scene.animation->values) values += key + " = " + value + "\n";
        metadata.emplace_back("animation", values);
    }
    if (is_adaptive(plan)) metadata.emplace_back("tolerance", shortest(plan.run.tolerance));
    if (plan.run.solver_tolerance > 0) metadata.emplace_back("solver_tolerance", shortest(plan.run.solver_tolerance));
    return metadata;
}

Metadata run_metadata(const RunReport& report) {
    Metadata metadata;
    std::string ends;
    for (std::uint32_t s = 0; s < status_count; ++s)
        append_to_list(ends, std::to_string(report.counters.ended[s]) + " " + name_of(static_cast<Status>(s)));
    if (report.rays) metadata.emplace_back("status", ends);  // The report of a snapshot has no counts.
    if (report.energy_error.p50 >= 0)                        // NaN if the error of H was not measured.
        metadata.emplace_back("energy_error", "median " + shortest(report.energy_error.p50) + ", 99 % " +
                                                  shortest(report.energy_error.p99) + ", greatest " +
                                                  shortest(report.energy_error.max));
    if (report.interrupted) metadata.emplace_back("interrupted", "yes: some pixels were never traced");
    return metadata;
}

}  // namespace kagero
