#include "report/profile/profile_html.h"

#include "error.h"
#include "plan/names.h"
#include "report/machine.h"
#include "report/profile/profile_charts.h"
#include "report/profile/profile_numbers.h"
#include "report/text/numbers.h"
#include "report/text/page.h"

#include <filesystem>

namespace kagero {
namespace {

std::string percent(double share, int digits = 1) { return fixed(100 * share, digits) + " %"; }

std::string facts(const Plan& plan, const Profile& profile) {
    const RunReport& report = profile.report;
    const Counters& work = report.counters;
    std::string text = "<div class=\"facts\">\n";
    text +=
        html_fact(html_text(rounded(double(report.rays) / report.seconds)) + " rays/s",
                  html_text(rounded(double(report.rays))) + " rays in " + html_number(1e3 * report.seconds) + " ms");
    text += html_fact(percent(ratio(double(work.active_lane_steps), double(work.issued_lane_steps))),
                      "mean occupancy of the " + std::to_string(plan.run.kernel->lanes) + " lanes of a packet");
    text += html_fact(fixed(ratio(double(work.queries), double(work.active_lane_steps)), 3),
                      "queries to Embree per active lane-step");
    text += html_fact(html_number(double(peak_memory()) / 1e6) + " MB", "peak memory");
    text += html_fact(html_text(plan.module().isa) + ", " + name_of(plan.run.kernel->precision) + ", " +
                          std::to_string(report.threads.size()) + (report.threads.size() == 1 ? " thread" : " threads"),
                      html_text(processor_name()) + "; kernels compiled by " + html_text(plan.module().compiler));
    text +=
        html_fact(html_text(plan.description().space.hamiltonian),
                  plan.scene->straight ? "space; rays are straight" : "space; method " + html_text(plan.method().name));
    return text + "</div>\n";
}

std::string threads_section(const Profile& profile) {
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < profile.report.threads.size(); ++i) {
        const ThreadTime& time = profile.report.threads[i];
        const ThreadShares shares = shares_of(profile.report, time);
        rows.push_back(
            {std::to_string(i), std::to_string(time.tiles), percent(shares.busy, 2), percent(shares.idle_at_end, 2)});
    }
    return html_figure("Threads", threads_chart(profile),
                       "Orange: prediction of the costs of tiles from a few rays. Blue: tracing. Green: shading. "
                       "Empty: idle.") +
           html_table({"thread", "tiles", "busy", "idle at the end"}, rows, 1);
}

std::string schedules_section(const Profile& profile) {
    std::vector<std::vector<std::string>> rows;
    for (const ScheduleTime& time : profile.schedules)
        rows.push_back({std::string(name_of(time.schedule)) +
                            (time.schedule == profile.report.schedule ? " <b>(used above)</b>" : ""),
                        html_number(1e3 * time.seconds) + " ms", percent(time.idle_at_end, 2)});
    return "<section class=\"keep\"><h2>Schedules</h2>\n" +
           html_table({"schedule", "time", "idle at the end"}, rows, 1) +
           "<p class=\"note\">The same picture with each schedule. Idle at the end: the share of the run for which the "
           "thread that finished first was idle.</p></section>\n";
}

std::string tiles_section(const Profile& profile) {
    std::string text = html_figure("Tiles", tiles_map(profile),
                                   "Darker tiles cost more per pixel. Each map is scaled to its greatest cost.");
    if (profile.correlation)
        text += html_figure("Prediction", prediction_chart(profile),
                            "Correlation " + fixed(*profile.correlation, 4) +
                                ". Before the picture is rendered, one ray per 11 × 11 pixels is traced, or four rays "
                                "per 16 × 16 pixels if a sky has an image. The predicted cost of a tile follows from "
                                "the gradients, steps and queries of these rays and from their look-ups in the image. "
                                "The slowest ray has the greatest weight, because a packet takes as many steps as its "
                                "slowest ray.");
    return text;
}

std::string roofline_section(const Plan& plan, const Profile& profile) {
    if (plan.scene->straight) return "";
    return html_figure(
        "Operations against the processor's peak", roofline_chart(profile),
        "Operations per second and thread, in " + std::string(name_of(plan.run.kernel->precision)) +
            ", during a run on " + std::to_string(profile.report.threads.size()) +
            (profile.report.threads.size() == 1 ? " thread" : " threads") +
            ". The operations are counted in the programs of the kernel: " + rounded(profile.operations.per_gradient) +
            " per gradient and " + rounded(profile.operations.per_step) +
            " per step. Operations for tests and step control are not counted, so the rates are lower bounds. The peak "
            "was measured in the same process with a loop of independent multiply-adds.");
}

std::string method_section(const Profile& profile) {
    return "<section><h2>Method of measurement</h2>\n<p>Times are those of the fastest of " +
           std::to_string(profile.rounds) +
           " interleaved runs of each configuration. Ratios are medians over rounds. A render took " +
           html_number(1e3 * profile.recorded_seconds) + " ms with recording and " +
           html_number(1e3 * profile.plain_seconds) + " ms without it (median overhead " +
           percent(profile.overhead, 2) +
           "). The stages within a kernel are separated by the processor's time-stamp counter, which is read before "
           "and after queries and refinement. The file <code>trace.json</code> in the same directory opens in Perfetto "
           "(ui.perfetto.dev) and speedscope.</p></section>\n";
}

}  // namespace

std::string profile_page(const Plan& plan, const Profile& profile, double write_seconds) {
    const std::string name = std::filesystem::path(plan.description().path).stem().string();
    std::string body = facts(plan, profile);
    body += html_figure(
        "Stages", stages_chart(profile, write_seconds),
        "Seconds summed over threads. Predict: prediction of the costs of tiles from a few rays. List rays: generation "
        "of rays outside the kernel. Integrate: steps along rays. Query: intersection of steps with the scene by "
        "Embree. Refine: refinement of events to points on the ray. Write: writing the picture, on one thread after "
        "the render.");
    body += threads_section(profile) + schedules_section(profile) + tiles_section(profile);
    if (profile.scaling.size() > 1)
        body += html_figure(
            "Scaling with threads", scaling_chart(profile),
            "Speedup over one thread, the median over rounds. Grey: the same for a loop of multiply-adds. This is the "
            "greatest speedup that the machine allowed during the measurement. Dashed: the ideal speedup N with N "
            "threads.");
    body += roofline_section(plan, profile) + method_section(profile);
    return html_page("Run time profile: " + name, plan.description().path + " · " + plan.scene->space.info().what,
                     body);
}

std::string profile_text(const Profile& profile, double write_seconds) {
    const auto stages = stages_of(profile, write_seconds);
    double all = 0;
    for (const auto& stage : stages) all += stage.second;
    std::string text;
    for (const auto& [name, seconds] : stages) append_to_list(text, name + " " + percent(ratio(seconds, all)));
    text += "\n";
    for (const ScheduleTime& time : profile.schedules)
        text += std::string(name_of(time.schedule)) + ": " + rounded(time.seconds) + " s, idle at the end " +
                percent(time.idle_at_end, 2) + "\n";
    for (const ThreadsTime& time : profile.scaling)
        text += std::to_string(time.threads) + (time.threads == 1 ? " thread: " : " threads: ") + "speedup " +
                fixed(time.speedup, 2) + " (multiply-adds: " + fixed(time.machine_speedup, 2) + ")\n";
    if (profile.correlation)
        text += "correlation of predicted and measured costs of tiles: " + fixed(*profile.correlation, 4) + "\n";
    if (profile.total_operations > 0)
        text += rounded(1e-9 * ratio(profile.total_operations, tracing_seconds(profile))) +
                " GFLOP/s per thread in tracing; peak of multiply-adds " +
                rounded(1e-9 * profile.all_threads_peak / double(profile.report.threads.size())) + " GFLOP/s\n";
    return text + "recording: " + percent(profile.overhead, 2) + " overhead (median over rounds); fastest run " +
           rounded(profile.recorded_seconds) + " s with recording, " + rounded(profile.plain_seconds) + " s without\n";
}

}  // namespace kagero
