#include "report/profile/profile_html.h"

#include "error.h"
#include "plan/names.h"
#include "report/machine.h"
#include "report/text/numbers.h"
#include "report/text/page.h"
#include "report/profile/profile_charts.h"
#include "report/profile/profile_numbers.h"

#include <filesystem>

namespace kagero {
namespace {

std::string percent(double share, int digits = 1) {
    return fixed(100 * share, digits) + " %";
}

std::string facts(const Plan& plan, const Profile& profile) {
    const RunReport& report = profile.report;
    const Counters& work = report.counters;
    std::string text = "<div class=\"facts\">\n";
    text +=
        html_fact(html_text(rounded(double(report.rays) / report.seconds)) + " rays/s",
                  html_text(rounded(double(report.rays))) + " rays in " + html_number(1e3 * report.seconds) + " ms");
    text += html_fact(percent(ratio(double(work.active_lane_steps), double(work.issued_lane_steps))),
                      "of the " + std::to_string(plan.run.kernel->lanes) + " lanes of a packet are active in a step");
    text += html_fact(fixed(ratio(double(work.queries), double(work.active_lane_steps)), 3),
                      "queries to Embree per lane and step");
    text += html_fact(html_number(double(peak_memory()) / 1e6) + " MB", "of memory at most");
    text += html_fact(html_text(plan.module().isa) + ", " + name_of(plan.run.kernel->precision) + ", " +
                          std::to_string(report.threads.size()) + (report.threads.size() == 1 ? " thread" : " threads"),
                      html_text(processor_name()) + "; kernels by compiler " + html_text(plan.module().compiler));
    text +=
        html_fact(html_text(plan.description().space.hamiltonian),
                  plan.scene->straight ? "leaves rays straight" : "bends the light; " + html_text(plan.method().name));
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
                       "Orange: the sparse first pass that predicts what tiles cost. Blue: tracing. Green: shading. "
                       "Empty: nothing to "
                       "do.") +
           html_table({"thread", "tiles", "busy", "idle at the end"}, rows, 1);
}

std::string schedules_section(const Profile& profile) {
    std::vector<std::vector<std::string>> rows;
    for (const ScheduleTime& time : profile.schedules)
        rows.push_back({std::string(name_of(time.schedule)) +
                            (time.schedule == profile.report.schedule ? " <b>(this one)</b>" : ""),
                        html_number(1e3 * time.seconds) + " ms", percent(time.idle_at_end, 2)});
    return "<section class=\"keep\"><h2>Schedules</h2>\n" +
           html_table({"schedule", "time", "idle at the end"}, rows, 1) +
           "<p class=\"note\">The same picture by each order of work. Idle at the end: the share of the time for which "
           "the "
           "thread "
           "that ran out of work first had none.</p></section>\n";
}

std::string tiles_section(const Profile& profile) {
    std::string text = html_figure("Tiles", tiles_map(profile), "The darker, the costlier, each by its own greatest.");
    if (profile.correlation)
        text += html_figure("Prediction", prediction_chart(profile),
                            "Correlation " + fixed(*profile.correlation, 4) +
                                ". A ray for every 11 × 11 pixels, or four for every 16 × 16, is followed before the "
                                "picture is begun; a tile's predicted cost is "
                                "that of the gradients, steps and queries of its rays, of which the slowest counts "
                                "most, and of the places of a "
                                "sky's image that they look up.");
    return text;
}

std::string roofline_section(const Plan& plan, const Profile& profile) {
    if (plan.scene->straight) return "";
    return html_figure(
        "Operations against the processor's peak", roofline_chart(profile),
        "Per thread, in " + std::string(name_of(plan.run.kernel->precision)) + ", with " +
            std::to_string(profile.report.threads.size()) +
            " threads at work. Counted in the programs that are run: " + rounded(profile.operations.per_gradient) +
            " operations per gradient and " + rounded(profile.operations.per_step) +
            " per step; what only tests and steers is not counted, so these are lower bounds. The peak was measured "
            "in the same process: nothing but multiply-adds.");
}

std::string method_section(const Profile& profile) {
    return "<section><h2>How it was measured</h2>\n<p>Times are those of the quickest of " +
           std::to_string(profile.repeats) +
           " runs of each kind, interleaved; ratios are medians over rounds. With recording a render took " +
           html_number(1e3 * profile.recorded_seconds) + " ms, without it " + html_number(1e3 * profile.plain_seconds) +
           " ms (" + percent(profile.overhead, 2) +
           " more). Stages within a kernel are told apart by the processor's clock, read around queries and around the "
           "delivery "
           "of rays. <code>trace.json</code> beside this page opens in Perfetto (ui.perfetto.dev) and "
           "speedscope.</p></section>\n";
}

}  // namespace

std::string profile_page(const Plan& plan, const Profile& profile, double write_seconds) {
    const std::string name = std::filesystem::path(plan.description().path).stem().string();
    std::string body = facts(plan, profile);
    body += html_figure(
        "Stages", stages_chart(profile, write_seconds),
        "Seconds summed over threads. Integrate: stepping along rays. Query: asking Embree what a step meets. Refine: "
        "delivering rays onto it. Write: one thread, after the render.");
    body += threads_section(profile) + schedules_section(profile) + tiles_section(profile);
    if (profile.scaling.size() > 1)
        body += html_figure(
            "More threads", scaling_chart(profile),
            "Speed over one thread, by the median of rounds; grey: multiply-adds alone, what the threads are "
            "worth on this machine at this time; dashed: N threads, N times as fast.");
    body += roofline_section(plan, profile) + method_section(profile);
    return html_page("Where the time goes: " + name,
                     plan.description().path + " · " + plan.scene->space.info().what, body);
}

std::string profile_text(const Profile& profile, double write_seconds) {
    const auto stages = stages_of(profile, write_seconds);
    double all = 0;
    for (const auto& stage : stages) all += stage.second;
    std::string text;
    for (const auto& [name, seconds] : stages) enumerate(text, name + " " + percent(ratio(seconds, all)));
    text += "\n";
    for (const ScheduleTime& time : profile.schedules)
        text += std::string(name_of(time.schedule)) + ": " + rounded(time.seconds) + " s, idle at the end " +
                percent(time.idle_at_end, 2) + "\n";
    for (const ThreadsTime& time : profile.scaling)
        text += std::to_string(time.threads) + (time.threads == 1 ? " thread: " : " threads: ") +
                fixed(time.speedup, 2) + " times as fast as one, multiply-adds alone " + fixed(time.machine, 2) + "\n";
    if (profile.correlation)
        text += "predicted and measured costs of tiles correlate by " + fixed(*profile.correlation, 4) + "\n";
    if (profile.all_operations > 0)
        text += rounded(1e-9 * ratio(profile.all_operations, tracing_seconds(profile))) +
                " GFLOP/s per thread while tracing, of " +
                rounded(1e-9 * profile.peak_of_all / double(profile.report.threads.size())) +
                " that multiply-adds alone reach\n";
    return text + "recording: " + percent(profile.overhead, 2) + " more time, median of the rounds; the best took " +
           rounded(profile.recorded_seconds) + " s with it and " + rounded(profile.plain_seconds) + " s without\n";
}

}  // namespace kagero
