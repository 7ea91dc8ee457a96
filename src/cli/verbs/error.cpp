// kagero error: error against run time, for the scene's own rays.
#include "study/error_study.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "film/partial_file.h"
#include "report/error/error_html.h"
#include "report/error/error_json.h"
#include "report/error/error_table.h"
#include "report/text/numbers.h"

#include <ostream>

namespace kagero {

namespace {

constexpr std::uint32_t most_sampled = 4096;

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output, "The directory of the report; default: SCENE-error here", "DIR");
    add_option(app, "--sample", arguments.sample, "The grid of pixels whose rays are followed; default: 64x64", "WxH");
    add_flag(app, "--quick", arguments.quick, "A handful of methods, less than a minute");
    add_flag(app, "--full", arguments.full, "Every method one ray at a time too");
    add_json(app, arguments);
    add_machine(app, arguments, "1, of the timed runs");
    add_messages(app, arguments);
}

StudyOptions study_options(const Arguments& arguments, const Options& options) {
    StudyOptions study;
    study.quick = arguments.quick, study.full = arguments.full;
    if (options.threads) study.threads = options.threads;
    study.precision = options.precision, study.strategy = options.strategy;
    if (study.strategy == Strategy::per_ray)
        throw InputError("--strategy: a study follows packets and single rays; `kagero compare` has per-ray");
    if (arguments.quick && arguments.full) throw InputError("--quick and --full exclude each other");
    if (arguments.sample.empty()) return study;
    const auto size = whole_numbers("--sample", arguments.sample, 'x', 2);
    for (const std::uint32_t n : size)
        if (n < 1 || n > most_sampled)
            throw InputError("--sample: " + arguments.sample + " has a side that is not in 1 to " +
                             std::to_string(most_sampled));
    study.width = size[0], study.height = size[1];
    return study;
}

ErrorStudy study_watched(const Plan& plan, const StudyOptions& options, const Terminal& terminal) {
    InterruptGuard guard;
    ProgressLine line(terminal);
    return study_error(
        plan, options, [&](double done, double seconds) { line.show(done, seconds); }, guard.requested());
}

void write_report(const std::string& directory, const Plan& plan, const ErrorStudy& study) {
    const auto put = [&](const char* name, const std::string& text) {
        write_text_file(path_in(directory, name), text);
    };
    put("results.json", error_json(plan, study));
    put("results.csv", error_csv(study));
    put("plot.gp", error_plot(plan, study));
    put("report.html", error_page(plan, study));
}

int run(const Arguments& arguments, const Terminal& terminal) {
    const Options options = options_of(arguments);
    const StudyOptions wanted = study_options(arguments, options);
    SceneDescription scene = scene_of(arguments, options);
    Options own;  // precision and strategy are those of the methods that are studied
    own.isa = options.isa, own.threads = options.threads;
    const Plan plan = make_plan(std::move(scene), own);
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    if (plan.description().integrator.max_pixel_error > 0)
        terminal.warning(
            std::string("integrator.max_pixel_error has no effect on a study of errors: the scene's own method is ") +
            plan.method().name);
    const std::string directory = report_directory(arguments, "error");
    const ReportDirectory made(directory, {"results.json", "results.csv", "plot.gp", "report.html"}, arguments.json,
                               files_of(plan.description()));
    const ErrorStudy study = study_watched(plan, wanted, terminal);
    write_report(directory, plan, study);
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) { out << error_json(plan, study); });
    if (arguments.json != "-") write_output("-", [&](std::ostream& out) { out << error_text(study); });
    terminal.note((study.interrupted ? "interrupted; what was done is in " : "the report is in ") + directory);
    return study.interrupted ? exit_interrupted : exit_done;
}

}  // namespace

const Verb error_verb{"error", "Measure error against run time, method by method, for a scene's own rays", declare,
                      run};

}  // namespace kagero
