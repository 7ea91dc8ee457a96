// kagero compare: compares the run times and pictures of the vectorization strategies.
#include "study/compare/compare.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "modules/modules.h"
#include "report/compare_report.h"

#include <algorithm>
#include <ostream>

namespace kagero {

namespace {

constexpr std::uint32_t max_rounds = 1000, max_lanes = 1024;
constexpr double default_seconds = 20;

void declare_compare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments, true);
    add_option(app, "--methods", arguments.methods,
               "Integration methods to compare, names from `kagero list integrators` separated by commas. Default: the "
               "method of the scene on the general path (integrator.symmetry = \"none\")",
               "A,B");
    add_option(app, "--equal-error", arguments.equal_error,
               "Compare each strategy with its cheapest method whose error is at most E pixels for 99 % of the rays; "
               "E > 0, excludes --methods. Default: the same method and step for all strategies",
               "E");
    add_option(app, "--baseline", arguments.baseline,
               "Compare all rows with scalar code in double on this instruction set, a name from `kagero list isas`. "
               "Default: each row with scalar code in double on its own instruction set",
               "ISA");
    add_option(app, "--rounds", arguments.rounds, "Number of interleaved rounds of timing, 1 to 1000. Default: 5", "N");
    add_option(app, "--seconds", arguments.seconds,
               "Reduce the picture so that the comparison takes about S seconds; 0: keep the size of the scene. "
               "Default: 20, and 0 with --size, -D film.size or --equal-error",
               "S");
    add_json(app, arguments);
    add_execution(app, arguments, "1");
    add_option(app, "--lanes", arguments.lanes,
               "Rays per packet to compare, numbers from `kagero list strategies` separated by commas. Default: every "
               "available number",
               "A,B");
    add_messages(app, arguments);
}

/// Returns the methods of a list separated by commas. Throws InputError if a method occurs twice.
std::vector<std::string> methods_of(const std::string& text) {
    std::vector<std::string> methods = split(text, ',');
    for (auto method = methods.begin(); method != methods.end(); ++method)
        if (std::find(methods.begin(), method, *method) != method)
            throw InputError("--methods: " + *method + " occurs twice; name each method once");
    return methods;
}

/// Returns CompareOptions::max_seconds.
double seconds_of(const Arguments& arguments) {
    const bool states_size =
        !arguments.size.empty() || std::any_of(arguments.overrides.begin(), arguments.overrides.end(),
                                               [](const std::string& text) { return text.starts_with("film.size"); });
    if (arguments.seconds.empty()) return states_size || !arguments.equal_error.empty() ? 0 : default_seconds;
    const double seconds = finite_number("--seconds", arguments.seconds);
    if (!(seconds >= 0))
        throw InputError("--seconds: " + arguments.seconds + " is less than 0; state a time in seconds");
    if (!arguments.equal_error.empty())
        throw InputError("--seconds and --equal-error exclude each other: the search for the methods takes longer; "
                         "leave one of them out");
    return seconds;
}

/// Converts the arguments. `--lanes` is a list of packet sizes here, not an override of integrator.lanes.
CompareOptions compare_options(const Arguments& arguments, const Options& options) {
    CompareOptions converted;
    converted.isas = find_isa_names(options.isa == "auto" ? "all" : options.isa);
    if (!arguments.baseline.empty()) {
        require_isa("--baseline", arguments.baseline);
        converted.baseline = find_isa_names(arguments.baseline).front();
    }
    if (options.threads) converted.threads = options.threads;
    converted.strategy = options.strategy;
    converted.precision = options.precision;
    if (!arguments.lanes.empty() && arguments.lanes != "auto")
        for (const std::string& word : split(arguments.lanes, ','))
            converted.lanes.push_back(count_of("--lanes", word, max_lanes));
    if (!arguments.methods.empty()) converted.methods = methods_of(arguments.methods);
    if (!arguments.rounds.empty()) converted.rounds = count_of("--rounds", arguments.rounds, max_rounds);
    converted.max_seconds = seconds_of(arguments);
    if (arguments.equal_error.empty()) return converted;
    converted.equal_error = finite_number("--equal-error", arguments.equal_error);
    if (!(converted.equal_error > 0))
        throw InputError("--equal-error: " + arguments.equal_error + " is not greater than 0 (in pixels)");
    if (!converted.methods.empty())
        throw InputError(
            "--equal-error and --methods exclude each other: --equal-error chooses the methods; leave one "
            "of them out");
    return converted;
}

Comparison compare_with_progress(const SceneDescription& scene, const CompareOptions& options,
                                 const Terminal& terminal) {
    InterruptGuard guard;
    ProgressLine line(terminal);
    return compare(
        scene, options, [&](double done, double seconds) { line.show(done, seconds); }, guard.requested());
}

int run_compare(const Arguments& arguments, const Terminal& terminal) {
    Options options = options_of(arguments);
    const CompareOptions requested = compare_options(arguments, options);
    options.isa = requested.isas.front();  // Every module accepts the same names in scenes.
    // The general path is compared, because strategies differ in how they evaluate H. Methods for the orbit plane do
    // not evaluate H.
    Arguments scene_arguments = arguments;  // `--lanes` does not override integrator.lanes here.
    scene_arguments.lanes.clear();
    const SceneDescription scene = general_path_scene(scene_reader(scene_arguments, options));
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    const Comparison comparison = compare_with_progress(scene, requested, terminal);
    for (const std::string& remark : comparison.remarks) terminal.warning(remark);
    if (arguments.json != "-")
        write_output("-", [&](std::ostream& out) { out << compare_text(scene, requested, comparison); });
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) { out << compare_json(scene, requested, comparison); });
    return comparison.interrupted ? exit_interrupted : exit_done;
}

}  // namespace

const Verb compare_verb{"compare", "Compare the vectorization strategies: run times, and differences of the pictures",
                        declare_compare, run_compare};

}  // namespace kagero
