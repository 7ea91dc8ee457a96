// kagero trace: single rays, as CSV in and out.
#include "cli/interrupt.h"
#include "cli/paths.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "plan/names.h"
#include "render/trace.h"
#include "report/csv/read_rays.h"
#include "report/run_json.h"
#include "report/csv/write_rays.h"
#include "tuning/resolve.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace kagero {

namespace {

constexpr std::uint32_t most_repeats = 1'000'000;

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments);
    add_option(app, "--rays", arguments.rays, "CSV with the columns x,y,z,dx,dy,dz; '-', the default, is stdin",
               "FILE");
    add_option(app, "-o,--output", arguments.output, "Where the CSV goes; '-', the default, is stdout", "FILE");
    add_flag(app, "--path", arguments.path, "Every step of every ray instead of its end");
    add_option(app, "--observer", arguments.observer,
               "Read directions in the rest frame of: static, zamo, falling, coordinate; default: as dq/dλ in the "
               "scene's coordinates",
               "NAME");
    add_option(app, "--parameter", arguments.parameter, "End every ray where its parameter has this value", "L");
    add_option(app, "--repeat", arguments.repeat, "With --json: how many runs to time", "N");
    add_json(app, arguments);
    add_machine(app, arguments);
    add_lanes(app, arguments);
    add_messages(app, arguments);
}

std::vector<RayInput> rays_of(const Arguments& arguments) {
    if (arguments.rays == "-") return read_rays(std::cin, "stdin");
    std::error_code ignored;
    if (std::filesystem::is_directory(arguments.rays, ignored))
        throw InputError("cannot read the rays '" + arguments.rays + "': it is a directory");
    std::ifstream in(arguments.rays, std::ios::binary);
    if (!in) throw InputError("cannot read the rays '" + arguments.rays + "': no such file, or no permission");
    return read_rays(in, arguments.rays);
}

/// What a list of rays is traced with.
struct Request {
    const Arguments& arguments;
    SceneDescription scene;
    Options options;
    std::vector<RayInput> rays;
    bool csv;
    const Terminal& terminal;
};

std::optional<ObserverKind> observer_of(const Arguments& arguments) {
    if (arguments.observer.empty()) return {};
    return observer_named(arguments.observer);
}

/// λ belongs to H: rays that are to end at a given λ follow no other clock. The scene on the general path, and without
/// a rescaling of the space's own, as if it said so, and with the defaults that follow.
SceneDescription scene_with_parameter(Arguments arguments, const Options& options) {
    const SceneDescription scene = general_scene_of(arguments, options);
    if (scene.integrator.rescale != "auto") return scene;
    arguments.overrides.push_back("integrator.rescale=none");
    return general_scene_of(arguments, options);
}

Plan plan_of(const Request& request, bool every_column) {
    SceneDescription scene = request.scene;
    Options options = request.options;
    options.energy_error = options.parameter = every_column;
    options.observer = observer_of(request.arguments);
    const std::string& limit = request.arguments.parameter;
    if (!limit.empty()) {
        if (scene.integrator.rescale != "none")
            throw InputError(
                "--parameter: a ray cannot be ended at a parameter of H while integrator.rescale changes that "
                "parameter; "
                "set it to \"none\"");
    }
    Plan plan = resolve(std::move(scene), options, Purpose::ray_list);
    if (every_column == request.csv)  // once, of both plans
        for (const std::string& remark : plan.remarks) request.terminal.warning(remark);
    if (!limit.empty() && plan.method().angular)
        throw InputError("--parameter: a ray cannot be ended at a parameter of H while integrator.method = \"" +
                         std::string(plan.method().name) + "\" steps in the angle of its orbit");
    if (!limit.empty()) plan.run.parameter_limit = finite_number("--parameter", limit);
    return plan;
}

/// Both return whether they were interrupted.
bool write_csv(const Request& request, const std::string& output, const Watch& watch) {
    const auto plan = plan_of(request, true);
    const auto starts = start_rays(plan, request.rays, observer_of(request.arguments));
    if (request.arguments.path) {
        write_paths_of(plan, starts, output, watch, request.terminal);
        return *watch.stop;
    }
    std::vector<RayEnd> ends;
    const RunReport report = trace(plan, starts, ends, watch);
    write_output(output, [&](std::ostream& out) { write_ends(out, plan, ends); });
    return report.interrupted;
}

/// Tracing alone, after one run that is not counted, to where rays end: without watching H, without λ. Of runs that
/// were cut short nothing is told.
std::size_t write_timing(const Request& request, std::uint32_t repetitions, const Watch& watch) {
    const auto plan = plan_of(request, false);
    const auto starts = start_rays(plan, request.rays, observer_of(request.arguments));
    std::vector<RayEnd> ends;
    trace(plan, starts, ends, watch);
    std::vector<RunReport> runs;
    for (std::uint32_t i = 0; i < repetitions && !*watch.stop; ++i) {
        RunReport report = trace(plan, starts, ends, watch);
        if (!report.interrupted) runs.push_back(std::move(report));
    }
    if (!runs.empty()) write_output(request.arguments.json, [&](std::ostream& out) { out << trace_json(plan, runs); });
    return runs.size();
}

void check_combination(const Arguments& arguments) {
    if (!arguments.observer.empty()) require_one_of("--observer", arguments.observer, observer_names());
    if (!arguments.parameter.empty() && !(finite_number("--parameter", arguments.parameter) > 0))
        throw InputError("--parameter: " + arguments.parameter + " is not greater than 0, where rays start");
    if (arguments.path && !arguments.json.empty())
        throw InputError("--path writes steps and --json reports on ends; ask for one of the two");
    if (!arguments.repeat.empty() && arguments.json.empty())
        throw InputError("--repeat times runs for a report; add --json");
    if (arguments.output == "-" && arguments.json == "-")
        throw InputError("CSV and JSON cannot both go to stdout; give --json a FILE");
}

int run(const Arguments& arguments, const Terminal& terminal) {
    check_combination(arguments);
    const std::uint32_t repetitions =
        arguments.repeat.empty() ? 1 : count_of("--repeat", arguments.repeat, most_repeats);
    const Options options = options_of(arguments);
    SceneDescription scene =
        arguments.parameter.empty() ? scene_of(arguments, options) : scene_with_parameter(arguments, options);
    const bool json = !arguments.json.empty();
    const bool csv = !json || !arguments.output.empty() || arguments.json != "-";
    const std::string output = arguments.output.empty() ? "-" : arguments.output;
    std::vector<NamedFile> inputs = files_of(scene);
    inputs.emplace_back("--rays", arguments.rays);
    check_outputs({{"-o", output}, {"--json", arguments.json}}, inputs);

    const Request request{arguments, std::move(scene), options, rays_of(arguments), csv, terminal};
    terminal.detail(std::to_string(request.rays.size()) + " rays");
    const InterruptGuard interrupts;
    Watch watch;
    watch.stop = InterruptGuard::requested();
    bool interrupted = csv && write_csv(request, output, watch), told = csv;
    if (json && !interrupted) {
        const std::size_t runs = write_timing(request, repetitions, watch);
        interrupted = runs < repetitions, told = told || runs > 0;
    }
    if (interrupted)
        terminal.note(told ? "interrupted; what was done is written"
                           : "interrupted before a run was complete: there is nothing to report");
    return interrupted ? exit_interrupted : exit_done;
}

}  // namespace

const Verb trace_verb{"trace", "Follow single rays given as CSV", declare, run};

}  // namespace kagero
