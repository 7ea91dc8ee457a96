// kagero error: measures error against run time for the rays of a scene.
#include "study/error_study.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/ranks/run_on_ranks.h"
#include "cli/verb.h"
#include "error.h"
#include "film/partial_file.h"
#include "parts/identity.h"
#include "parts/journals/entry_journal.h"
#include "ranks/agreement.h"
#include "ranks/gather_points.h"
#include "ranks/shared_scene.h"
#include "report/error/error_html.h"
#include "report/error/error_json.h"
#include "report/error/error_table.h"
#include "report/text/numbers.h"

#include <ostream>

namespace kagero {

namespace {

constexpr std::uint32_t max_sample_size = 4096;

void declare_error(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "-o,--output", arguments.output,
               "Directory for the report: results.json, results.csv, plot.gp and report.html. Default: SCENE-error in "
               "the working directory",
               "DIR");
    add_option(app, "--sample", arguments.sample,
               "Grid of pixels whose rays are traced: columns and rows, each 1 to 4096. Default: 64x64", "WxH");
    add_flag(app, "--quick", arguments.quick,
             "Measure only a few representative methods, which takes less than a minute. Excludes --full");
    add_flag(app, "--full", arguments.full,
             "Measure every method also with strategy scalar, one ray at a time. Excludes --quick");
    add_flag(app, "--resume", arguments.resume,
             "Keep the errors of finished steps in DIR/error.journal, and continue from it if it exists. Run times are "
             "measured again, except with --quick. The journal is removed when the report is complete. Requires -o");
    add_rank_options(app, arguments, "error");
    add_json(app, arguments);
    add_execution(app, arguments, "1 for timed runs and the number of processors for other runs");
    add_messages(app, arguments);
}

StudyOptions study_options(const Arguments& arguments, const Options& options) {
    StudyOptions study;
    study.quick = arguments.quick;
    study.full = arguments.full;
    if (options.threads) study.threads = options.threads;
    study.precision = options.precision;
    study.strategy = options.strategy;
    if (study.strategy == Strategy::per_ray)
        throw InputError(
            "--strategy: per-ray is not available in `kagero error`; choose auto, scalar or packet "
            "(`kagero compare` measures per-ray)");
    if (arguments.quick && arguments.full)
        throw InputError("--quick and --full exclude each other; leave one of them out");
    if (arguments.sample.empty()) return study;
    const auto size = whole_numbers("--sample", arguments.sample, 'x', 2);
    for (const std::uint32_t n : size)
        if (n < 1 || n > max_sample_size)
            throw InputError("--sample: " + arguments.sample + " is out of range; columns and rows must be from 1 to " +
                             std::to_string(max_sample_size));
    study.width = size[0];
    study.height = size[1];
    return study;
}

/// Returns what must be the same for a study that continues. Its run times belong to one processor.
Properties identity_of_study(const Plan& plan, const Options& options, const StudyOptions& study) {
    Properties identity = identity_of(plan, options);
    identity.insert(identity.end(), {{"the sample", std::to_string(study.width) + "x" + std::to_string(study.height)},
                                     {"the extent of the study", study.quick  ? "--quick"
                                                                 : study.full ? "--full"
                                                                              : "the default"},
                                     {"the number of threads", std::to_string(study.threads)}});
    return identity;
}

/// Returns the plan whose rays are studied. --precision and --strategy select curves of the study; they do not apply to
/// this plan.
Plan plan_of_study(SceneDescription scene, const Options& options) {
    Options plan_options;
    plan_options.isa = options.isa;
    plan_options.threads = options.threads;
    Plan plan = make_plan(std::move(scene), plan_options);
    if (plan.description().integrator.max_pixel_error > 0)
        plan.remarks.push_back(
            std::string("integrator.max_pixel_error has no effect on `kagero error`; the method of the scene is ") +
            plan.method().name);
    return plan;
}

/// Runs the study, on all ranks if `ranks` is not null. `journal` may be null.
ErrorStudy study_with_progress(const Plan& plan, StudyOptions options, const Properties& identity,
                               EntryJournal* journal, Communicator* ranks, const Terminal& terminal) {
    const InterruptGuard guard;
    ProgressLine line(terminal);
    const Progress progress = [&](double done, double seconds) { line.show(done, seconds); };
    const auto keep = [&](const std::string& name, const PointContent& content) {
        if (journal) journal->append(name, content);
    };
    NamedPoints finished;
    if (journal)
        for (const auto& [name, entry] : journal->entries()) finished[name] = entry.get<PointContent>();
    if (ranks) {
        agree_on_properties(*ranks, identity);
        finished = share_points(*ranks, finished);
        return study_on_ranks(*ranks, plan, options, finished, keep, progress, guard.requested());
    }
    options.store.find = [&](const std::string& name) {
        const auto found = finished.find(name);
        return found == finished.end() ? std::nullopt : std::optional(found->second);
    };
    options.store.keep = keep;
    return study_error(plan, options, progress, guard.requested());
}

/// The work of a rank other than rank 0: it measures points, and rank 0 uses them.
int study_for_root(const Arguments& arguments, const Options& options, const StudyOptions& requested,
                   const Terminal& terminal, Communicator& ranks) {
    const ReceivedScene received(ranks);
    SceneDescription scene = scene_of_text(arguments, options, received.text(), received.path());
    received.check_paths(scene);
    const Plan plan = plan_of_study(std::move(scene), options);
    study_with_progress(plan, requested, identity_of_study(plan, options, requested), nullptr, &ranks, terminal);
    return exit_done;
}

void write_report(const std::string& directory, const Plan& plan, const ErrorStudy& study) {
    const auto write = [&](const char* name, const std::string& text) {
        write_text_file(path_in(directory, name), text);
    };
    write("results.json", error_json(plan, study));
    write("results.csv", error_csv(study));
    write("plot.gp", error_plot(plan, study));
    write("report.html", error_page(plan, study));
}

/// Runs the verb. `ranks` is null without --mpi.
int measure_errors(const Arguments& arguments, const Terminal& terminal, Communicator* ranks) {
    check_rank_combination(arguments);
    Options options = options_of(arguments);
    const StudyOptions requested = study_options(arguments, options);
    if (arguments.resume && arguments.output.empty())
        throw InputError("--resume keeps its journal in the directory of the report; state it with -o DIR");
    if (ranks) set_up_rank(*ranks, options, terminal);
    if (ranks && ranks->rank() > 0) return study_for_root(arguments, options, requested, terminal, *ranks);
    SceneDescription scene = scene_of(arguments, options);
    if (ranks) share_scene(*ranks, scene, arguments.send_files);
    const Plan plan = plan_of_study(std::move(scene), options);
    for (const std::string& remark : plan.remarks) terminal.warning(remark);
    const std::string directory = report_directory(arguments, "error");
    const ReportDirectory report(directory, {"results.json", "results.csv", "plot.gp", "report.html"}, arguments.json,
                                 files_of(plan.description()));
    const Properties identity = identity_of_study(plan, options, requested);
    std::optional<EntryJournal> journal;
    if (arguments.resume) journal.emplace(path_in(directory, "error.journal"), identity);
    const ErrorStudy study =
        study_with_progress(plan, requested, identity, journal ? &*journal : nullptr, ranks, terminal);
    write_report(directory, plan, study);
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) { out << error_json(plan, study); });
    if (arguments.json != "-") write_output("-", [&](std::ostream& out) { out << error_text(study); });
    if (journal && !study.interrupted) journal->remove();
    terminal.note((study.interrupted ? "interrupted; the results so far are in " : "the report is in ") + directory);
    return study.interrupted ? exit_interrupted : exit_done;
}

int run_error(const Arguments& arguments, const Terminal& terminal) {
    if (!arguments.mpi) return measure_errors(arguments, terminal, nullptr);
    return run_on_ranks(arguments, terminal,
                        [](const Arguments& of_rank, const Terminal& terminal_of_rank, Communicator& ranks) {
                            return measure_errors(of_rank, terminal_of_rank, &ranks);
                        });
}

}  // namespace

const Verb error_verb{"error", "Measure error against run time for the rays of a scene, method by method",
                      declare_error, run_error};

}  // namespace kagero
