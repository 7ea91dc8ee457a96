#include "cli/resolve.h"

#include "report/warnings.h"

namespace kagero {

Plan resolve_with_progress(SceneDescription scene, const Options& options, const Terminal& terminal) {
    return tune_with_progress(make_plan(std::move(scene), options), options, terminal);
}

Plan tune_with_progress(Plan plan, const Options& options, const Terminal& terminal) {
    constexpr double delay = 1;  // seconds before progress is shown
    ProgressLine line(terminal, " of the trial rays");
    RunControl control;
    control.progress = [&](double done, double seconds) {
        if (seconds > delay) line.show(done, seconds);
    };
    plan = tune(std::move(plan), options, Purpose::picture, control);
    line.clear();
    print_remarks(plan, terminal);
    return plan;
}

void print_remarks(const Plan& plan, const Terminal& terminal) {
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    for (const Warning& warning : warnings_of_trial(plan)) terminal.warning(warning.text);
}

}  // namespace kagero
