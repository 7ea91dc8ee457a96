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
#include "tuning/resolve.h"

#include <algorithm>
#include <ostream>

namespace kagero {

namespace {

constexpr std::uint32_t max_repeats = 1'000'000, max_bounces = 1000;

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

/// Reads the scene for rays that end at a given λ. λ is the parameter of Hamilton's equations for H, so rays must be
/// integrated on the general path and without time rescaling. If integrator.rescale is "auto", it is replaced by
/// "none", which also selects the default method and step for H without rescaling.
SceneDescription scene_with_parameter(Arguments arguments, const Options& options) {
    const SceneDescription scene = general_path_scene_of(arguments, options);
    if (scene.integrator.rescale != "auto") return scene;
    arguments.overrides.push_back("integrator.rescale=none");
    return general_path_scene_of(arguments, options);
}

/// Returns the number of surfaces through which rays continue; empty: they end at the first surface.
std::optional<std::uint32_t> bounces_of(const Arguments& arguments) {
    const std::uint32_t bounces =
        arguments.bounces.empty() ? 0 : count_of("--bounces", arguments.bounces, max_bounces, 0);
    return bounces > 0 ? std::optional(bounces) : std::nullopt;
}

/// Returns the plan for the CSV, whose columns include the error of H and λ, or for the timed runs of the JSON report.
/// Prints the remarks of the plan as warnings, only once if both CSV and JSON are written.
Plan plan_of(const Request& request, bool for_csv) {
    SceneDescription scene = request.scene;
    Options options = request.options;
    options.energy_error = options.parameter = for_csv;
    request_columns(request.arguments, options);
    options.observer = observer_of(request.arguments);
    options.bounces = bounces_of(request.arguments);
    const std::string& limit = request.arguments.parameter;
    if (!limit.empty()) {
        if (scene.integrator.rescale != "none")
            throw InputError(
                "--parameter: rays cannot end at a value of the ray parameter while integrator.rescale replaces it by "
                "another integration parameter; set integrator.rescale = \"none\"");
    }
    Plan plan = resolve(std::move(scene), options, Purpose::ray_list);
    if (for_csv == request.writes_csv)
        for (const std::string& remark : plan.remarks) request.terminal.warning(remark);
    if (!limit.empty() && plan.method().angular)
        throw InputError(
            "--parameter: rays cannot end at a value of the ray parameter, because integrator.method = \"" +
            std::string(plan.method().name) + "\" steps in an angle; choose a method other than orbit-* and mino-*");
    if (!limit.empty()) plan.run.parameter_limit = finite_number("--parameter", limit);
    if (!request.arguments.every.empty()) plan.run.path_interval = finite_number("--every", request.arguments.every);
    return plan;
}

/// Traces the rays and writes their ends or paths as CSV. Returns true if the run was interrupted.
bool write_csv(const Request& request, const std::string& output, const RunControl& control) {
    const auto plan = plan_of(request, true);
    const auto starts = start_rays(plan, request.rays, observer_of(request.arguments));
    if (request.arguments.path) {
        write_paths_of(plan, starts, output, control, request.terminal);
        return *control.stop;
    }
    std::vector<RayEnd> ends;
    std::vector<PathState> paths;
    const RunReport report = trace(plan, starts, ends, control, &paths);
    const bool writes_paths = !request.arguments.bounces.empty();
    write_output(output, [&](std::ostream& out) { write_ends(out, plan, ends, writes_paths ? &paths : nullptr); });
    for (const Warning& warning : warnings_of(plan, report)) request.terminal.warning(warning.text);
    return report.interrupted;
}

/// Traces the rays `repetitions` times, after one run that is not timed, and writes the JSON report. Returns the number
/// of complete runs. The timed runs compute neither the error of H nor λ; the first run measures the error of H for the
/// warnings. Interrupted runs are not reported.
std::size_t write_timing(const Request& request, std::uint32_t repetitions, const RunControl& control) {
    const auto plan = plan_of(request, false);
    const auto starts = start_rays(plan, request.rays, observer_of(request.arguments));
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
    if (!arguments.parameter.empty() && !(finite_number("--parameter", arguments.parameter) > 0))
        throw InputError("--parameter: " + arguments.parameter +
                         " is not greater than 0, the value at the start of a ray");
    if (!arguments.every.empty()) {
        if (!arguments.path) throw InputError("--every has an effect only on the points of --path; add --path");
        if (!(finite_number("--every", arguments.every) > 0))
            throw InputError("--every: " + arguments.every + " is not greater than 0");
    }
    if (!arguments.bounces.empty() && !arguments.parameter.empty())
        throw InputError("--bounces and --parameter exclude each other: each medium has its own ray parameter");
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
    const Options options = options_of(arguments);
    SceneDescription scene = arguments.parameter.empty() ? scene_of(arguments, options, SceneUse::single_rays)
                                                         : scene_with_parameter(arguments, options);
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
