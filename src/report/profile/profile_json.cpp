#include "report/profile/profile_json.h"

#include "plan/names.h"
#include "report/json.h"
#include "report/machine.h"
#include "report/profile/profile_numbers.h"
#include "report/warnings.h"

namespace kagero {
namespace {

Json stages_json(const StageTimes& stages, double write_seconds) {
    return {{"predict", stages.predict}, {"list", stages.list},     {"integrate", stages.integrate},
            {"query", stages.query},     {"refine", stages.refine}, {"shade", stages.shade},
            {"write", write_seconds}};
}

Json tiles_json(const Profile& profile) {
    const double unit = seconds_per_predicted(profile);
    Json rows = Json::array();
    for (const TileRecord& t : profile.recording.tiles)
        rows.push_back({{"x0", t.tile.x0},
                        {"y0", t.tile.y0},
                        {"x1", t.tile.x1},
                        {"y1", t.tile.y1},
                        {"thread", t.thread},
                        {"begin", t.begin},
                        {"end", t.end},
                        {"predicted", unit * t.predicted},
                        {"measured", t.processor_time},
                        {"gradients", t.counters.gradients},
                        {"queries", t.counters.queries}});
    return {{"count", rows.size()},
            {"correlation", profile.correlation ? Json(*profile.correlation) : Json()},
            {"rows", rows}};
}

/// Returns operation counts and operation rates. Keys with `gflops` are in units of 10⁹ operations per second.
Json roofline_json(const Profile& profile) {
    const double threads = double(profile.report.threads.size()), peak = profile.all_threads_peak / threads;
    const double tracing = ratio(profile.total_operations, tracing_seconds(profile));
    const double integrating = ratio(profile.total_operations, profile.stages.integrate + profile.stages.refine);
    return {{"operations_per_gradient", profile.operations.per_gradient},
            {"operations_per_step", profile.operations.per_step},
            {"operations", profile.total_operations},
            {"gflops", 1e-9 * ratio(profile.total_operations, profile.recorded_seconds)},
            {"gflops_tracing_per_thread", 1e-9 * tracing},
            {"gflops_integrating_per_thread", 1e-9 * integrating},
            {"peak_gflops_one_thread", 1e-9 * profile.one_thread_peak},
            {"peak_gflops_all_threads", 1e-9 * profile.all_threads_peak},
            {"share_of_peak", ratio(tracing, peak)},
            {"share_of_peak_integrating", ratio(integrating, peak)}};
}

Json scaling_json(const Profile& profile) {
    Json rows = Json::array();
    for (const ThreadsTime& time : profile.scaling)
        rows.push_back({{"threads", time.threads},
                        {"seconds", time.seconds},
                        {"speedup", time.speedup},
                        {"efficiency", time.speedup / time.threads},
                        {"machine_speedup", time.machine_speedup}});
    return rows;
}

Json schedules_json(const Profile& profile) {
    Json rows = Json::array();
    for (const ScheduleTime& time : profile.schedules)
        rows.push_back(
            {{"schedule", name_of(time.schedule)}, {"seconds", time.seconds}, {"idle_at_end", time.idle_at_end}});
    return rows;
}

}  // namespace

std::string profile_json(const Plan& plan, const Profile& profile, double write_seconds) {
    const RunReport& report = profile.report;
    const Counters& work = report.counters;
    Json json;
    json["scene"] = plan.description().path;
    json["isa"] = plan.module().isa;
    json["strategy"] = name_of(plan.run.kernel->strategy);
    json["precision"] = name_of(plan.run.kernel->precision);
    json["lanes"] = plan.run.kernel->lanes;
    json["threads"] = report.threads.size();
    json["schedule"] = name_of(report.schedule);
    json["processor"] = processor_name();
    json["compiler"] = plan.module().compiler;
    json["rays"] = report.rays;
    json["seconds"] = report.seconds;
    json["mrays_per_s"] = 1e-6 * ratio(double(report.rays), report.seconds);
    json["steps"] = work.steps;
    json["gradients"] = work.gradients;
    json["queries"] = work.queries;
    json["lane_occupancy"] = ratio(double(work.active_lane_steps), double(work.issued_lane_steps));
    json["iteration_occupancy"] =
        work.issued_iterations ? Json(ratio(double(work.active_iterations), double(work.issued_iterations))) : Json();
    json["queries_per_lane_step"] = ratio(double(work.queries), double(work.active_lane_steps));
    json["stages"] = stages_json(profile.stages, write_seconds);
    json["thread_times"] = threads_json(report);
    json["roofline"] = roofline_json(profile);
    json["memory"] = {{"peak_bytes", peak_memory()}};
    json["overhead"] = {{"plain_s", profile.plain_seconds},
                        {"recorded_s", profile.recorded_seconds},
                        {"share", profile.overhead}};
    json["schedules"] = schedules_json(profile);
    json["scaling"] = scaling_json(profile);
    json["repeats"] = profile.rounds;
    json["tiles"] = tiles_json(profile);
    json["remarks"] = plan.remarks;
    json["warnings"] = warnings_json(warnings_of_trial(plan));
    return text_of(json);
}

}  // namespace kagero
