// kagero compare: the vectorization strategies side by side.
#include "study/compare.h"

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

constexpr std::uint32_t most_rounds = 1000, most_lanes = 1024;

void declare(CLI::App& app, Arguments& arguments) {
    add_scene(app, arguments, true);
    add_option(app, "--methods", arguments.methods,
               "Integrators to compare by; default: the scene's, or what it would be without the plane of the orbit",
               "A,B");
    add_option(app, "--equal-error", arguments.equal_error,
                   "Each strategy by its own cheapest method that brings 99 % of the rays within E pixels", "E");
    add_option(app, "--rounds", arguments.rounds, "Interleaved rounds; default: 5", "N");
    add_json(app, arguments);
    add_machine(app, arguments, "1");
    add_option(app, "--lanes", arguments.lanes,
               "Rays at a time of the packets to compare; default: every number there is", "A,B");
    add_messages(app, arguments);
}

/// Methods separated by commas, each once.
std::vector<std::string> methods_of(const std::string& text) {
    std::vector<std::string> methods = split(text, ',');
    for (auto method = methods.begin(); method != methods.end(); ++method)
        if (std::find(methods.begin(), method, *method) != method)
            throw InputError("--methods: " + *method + " stands there twice");
    return methods;
}

/// --lanes is a list here, and not a key of the scene.
CompareOptions compare_options(const Arguments& arguments, const Options& options) {
    CompareOptions compared;
    compared.isas = isas_for(options.isa == "auto" ? "all" : options.isa);
    if (options.threads) compared.threads = options.threads;
    compared.strategy = options.strategy, compared.precision = options.precision;
    if (!arguments.lanes.empty() && arguments.lanes != "auto")
        for (const std::string& word : split(arguments.lanes, ','))
            compared.lanes.push_back(count_of("--lanes", word, most_lanes));
    if (!arguments.methods.empty()) compared.methods = methods_of(arguments.methods);
    if (!arguments.rounds.empty()) compared.rounds = count_of("--rounds", arguments.rounds, most_rounds);
    if (arguments.equal_error.empty()) return compared;
    compared.equal_error = finite_number("--equal-error", arguments.equal_error);
    if (!(compared.equal_error > 0))
        throw InputError("--equal-error: " + arguments.equal_error + " is not greater than 0");
    if (!compared.methods.empty()) throw InputError("--equal-error chooses the methods itself; leave --methods out");
    return compared;
}

Comparison compare_watched(const SceneDescription& scene, const CompareOptions& options, const Terminal& terminal) {
    InterruptGuard guard;
    ProgressLine line(terminal);
    return compare(
        scene, options, [&](double done, double seconds) { line.show(done, seconds); }, guard.requested());
}

int run(const Arguments& arguments, const Terminal& terminal) {
    Options options = options_of(arguments);
    const CompareOptions compared = compare_options(arguments, options);
    options.isa = compared.isas.front();  // names in scenes are the same for all
    Arguments general = arguments;  // the strategies differ in how they integrate H, which an orbit plane leaves out
    general.lanes.clear();
    const SceneDescription scene = general_scene_of(general, options);
    check_outputs({{"--json", arguments.json}}, files_of(scene));
    const Comparison comparison = compare_watched(scene, compared, terminal);
    for (const std::string& remark : comparison.remarks) terminal.warning(remark);
    if (arguments.json != "-") write_output("-", [&](std::ostream& out) { out << compare_text(compared, comparison); });
    if (!arguments.json.empty())
        write_output(arguments.json, [&](std::ostream& out) { out << compare_json(scene, compared, comparison); });
    return comparison.interrupted ? exit_interrupted : exit_done;
}

}  // namespace

const Verb compare_verb{"compare",
                        "Set the vectorization strategies side by side: time, and difference of the pictures", declare,
                        run};

}  // namespace kagero
