// kagero trace: traces single rays that are read as CSV, and writes their ends or paths as CSV.
#include "render/trace.h"
#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/paths.h"
#include "cli/ray_options.h"
#include "cli/verb.h"
#include "error.h"
#include "plan/names.h"
#include "report/csv/write_rays.h"
#include "report/run_json.h"
#include "report/warnings.h"

#include <algorithm>
#include <ostream>

namespace kagero {

namespace {

constexpr std::uint32_t max_repeats = 1'000'000;
constexpr const char* option_prefix = "--";  ///< Stands in front of the names of options in messages.

void declare_trace(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_ray_options(app, arguments);
    add_option(app, "-o,--output", arguments.output,
               "File for the CSV of results; '-' is stdout. Default: -, or no CSV if --json writes to stdout", "FILE");
    add_flag(app, "--path", arguments.path, "Write every step of every ray instead of its end. Excludes --json");
    add_option(app, "--every", arguments.every,
               "With --path, write the points at the multiples of L of λ instead of the steps. Each point is computed "
               "by a part of a step of the method. Default: every step",
               "L");
    add_columns(app, arguments, "Each adds a column to the CSV and an array to the JSON.");
    add_option(app, "--parameter", arguments.parameter,
               "End every ray at this value of the ray parameter λ, L > 0, with status step_limit. λ is 0 at the "
               "start. Default: no limit",
               "L");
    add_option(app, "--bounces", arguments.bounces,
               "Number of surfaces through which a ray continues, 0 to 1000: mirrors and boundaries of media. It takes "
               "the stronger branch. Adds the columns bounces, medium and weight. Excludes --parameter. Default: 0, a "
               "ray ends at the first surface",
               "N");
    add_option(app, "--repeat", arguments.repeat,
               "Number of timed runs for the report of --json, 1 to 1000000; one more run before them is not timed. "
               "Default: 1",
               "N");
    add_json(app, arguments);
    add_execution(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

/// The rays to trace, with the scene and the options.
struct Request {
    const Arguments& arguments;
    SceneDescription scene;
    Options options;
    std::vector<RayInput> rays;
    bool writes_csv;  ///< True if ends or paths are written as CSV, with or without a JSON report.
    const Terminal& terminal;
};

/// Returns the options of the command line, with those that only lists of rays have. Throws InputError.
Options options_of_trace(const Arguments& arguments) {
    Options options = options_of(arguments);
    request_columns(arguments, options);
    options.observer = observer_of(arguments);
    if (!arguments.bounces.empty()) options.bounces = count_of("--bounces", arguments.bounces, max_ray_bounces, 0);
    if (!arguments.parameter.empty()) options.parameter_limit = finite_number("--parameter", arguments.parameter);
    if (!arguments.every.empty()) options.path_interval = finite_number("--every", arguments.every);
    check_ray_list(options, option_prefix);
    return options;
}

/// Returns the plan for the CSV, whose columns include the error of H and λ, or for the timed runs of the JSON report.
/// Prints the remarks of the plan as warnings, only once if both CSV and JSON are written.
Plan plan_of(const Request& request, bool for_csv) {
    Options options = request.options;
    options.energy_error = options.parameter = for_csv;
    Plan plan = resolve_ray_list(request.scene, options, option_prefix);
    if (for_csv == request.writes_csv)
        for (const std::string& remark : plan.remarks) request.terminal.warning(remark);
    return plan;
}

/// Traces the rays and writes their ends or paths as CSV. Returns true if the run was interrupted.
bool write_csv(const Request& request, const std::string& output, const RunControl& control) {
    const auto plan = plan_of(request, true);
    const auto starts = start_rays(plan, request.rays, request.options.observer);
    if (request.arguments.path) {
        write_paths_of(plan, starts, request.options.bounces.has_value(), output, control, request.terminal);
        return *control.stop;
    }
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    const RunReport report = trace(plan, starts, ends, control, &paths);
    const std::vector<PathState>* written_paths = request.options.bounces ? &paths : nullptr;
    write_output(output, [&](std::ostream& out) { write_ends(out, plan, ends, written_paths); });
    for (const Warning& warning : warnings_of(plan, report)) request.terminal.warning(warning.text);
    return report.interrupted;
}

/// Traces the rays `repetitions` times, after one run that is not timed, and writes the JSON report. Returns the number
/// of complete runs. The timed runs compute neither the error of H nor λ; the first run measures the error of H for the
/// warnings. Interrupted runs are not reported.
std::size_t write_timing(const Request& request, std::uint32_t repetitions, const RunControl& control) {
    const auto plan = plan_of(request, false);
    const auto starts = start_rays(plan, request.rays, request.options.observer);
    std::vector<RayEnd> ends;
    Plan with_energy = plan;
    with_energy.run.outputs |= output_energy;
    const std::vector<Warning> warnings = warnings_of(plan, trace(with_energy, starts, ends, control));
    if (!request.writes_csv)
        for (const Warning& warning : warnings) request.terminal.warning(warning.text);
    std::vector<RunReport> runs;
    for (std::uint32_t i = 0; i < repetitions && !*control.stop; ++i) {
        RunReport report = trace(plan, starts, ends, control);
        if (!report.interrupted) runs.push_back(std::move(report));
    }
    if (!runs.empty())
        write_output(request.arguments.json, [&](std::ostream& out) { out << trace_json(plan, runs, ends, warnings); });
    return runs.size();
}

/// Throws InputError for invalid values of options, and for options that cannot be combined.
void check_trace_options(const Arguments& arguments) {
    if (!arguments.observer.empty()) require_one_of("--observer", arguments.observer, observer_names());
    if (!arguments.every.empty() && !arguments.path)
        throw InputError("--every has an effect only on the points of --path; add --path");
    if (arguments.path && !arguments.json.empty())
        throw InputError("--path and --json exclude each other: the JSON reports on ray ends; use one of the two");
    if (!arguments.repeat.empty() && arguments.json.empty())
        throw InputError("--repeat has an effect only on the report of --json; add --json, or leave --repeat out");
    if (arguments.output == "-" && arguments.json == "-")
        throw InputError("CSV and JSON cannot both be written to stdout; add a file: --json FILE or -o FILE");
}

int run_trace(const Arguments& arguments, const Terminal& terminal) {
    check_trace_options(arguments);
    const std::uint32_t repetitions =
        arguments.repeat.empty() ? 1 : count_of("--repeat", arguments.repeat, max_repeats);
    const Options options = options_of_trace(arguments);
    SceneDescription scene = ray_list_scene(scene_reader(arguments, options), options.parameter_limit.has_value());
    const bool json = !arguments.json.empty();
    const bool csv = !json || !arguments.output.empty() || arguments.json != "-";
    const std::string output = arguments.output.empty() ? "-" : arguments.output;
    std::vector<NamedFile> inputs = files_of(scene);
    inputs.emplace_back("--rays", arguments.rays);
    check_outputs({{"-o", output}, {"--json", arguments.json}}, inputs);

    const Request request{arguments, std::move(scene), options, rays_of(arguments), csv, terminal};
    terminal.detail(std::to_string(request.rays.size()) + " rays");
    const InterruptGuard interrupts;
    RunControl control;
    control.stop = InterruptGuard::requested();
    bool interrupted = csv && write_csv(request, output, control), has_output = csv;
    if (json && !interrupted) {
        const std::size_t runs = write_timing(request, repetitions, control);
        interrupted = runs < repetitions;
        has_output = has_output || runs > 0;
    }
    if (interrupted)
        terminal.note(has_output ? "interrupted; the results so far are written"
                                 : "interrupted before a run was complete; no report is written");
    return interrupted ? exit_interrupted : exit_done;
}

}  // namespace

const Verb trace_verb{"trace", "Trace single rays that are given as CSV", declare_trace, run_trace};

}  // namespace kagero
