// kagero stability: compares stiff and extreme cases with results known from theory.
#include "stability/stability.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "modules/modules.h"
#include "report/stability_report.h"

#include <algorithm>
#include <optional>
#include <ostream>

namespace kagero {

namespace {

void declare(CLI::App& app, Arguments& arguments) {
    add_option(app, "CASE", arguments.cases, "Names of the cases to run. Default: all cases", "");
    add_option(app, "-o,--output", arguments.output,
               "Directory for stability.html and stability.json. Default: no files are written", "DIR");
    add_isa(app, arguments, true);
    add_json(app, arguments);
    add_execution(app, arguments);
    add_messages(app, arguments);
}

StabilityRequest request_of(const Arguments& arguments) {
    const Options options = options_of(arguments);
    if (options.strategy == Strategy::per_ray)
        throw InputError("--strategy: per-ray kernels exist only for a few spaces; choose auto, scalar or packet");
    StabilityRequest request;
    request.isas = find_isa_names(options.isa);
    request.threads = options.threads;
    if (options.precision) request.precisions = {*options.precision};
    if (options.strategy) request.strategies = {*options.strategy};
    return request;
}

/// Moves the value of `--json` to the cases if it is the name of a case.
void restore_case(std::vector<std::string>& cases, std::string& json) {
    if (!json_is_positional(json, stability_case_names(), "a case")) return;
    cases.push_back(json);
    json = "-";
}

int run(const Arguments& arguments, const Terminal& terminal) {
    std::vector<std::string> cases = arguments.cases;
    std::string json = arguments.json;
    restore_case(cases, json);
    require_cases(cases);
    const StabilityRequest request = request_of(arguments);
    std::optional<ReportDirectory> directory;
    if (arguments.output.empty()) check_outputs({{"--json", json}});
    else directory.emplace(arguments.output, std::vector<std::string>{"stability.html", "stability.json"}, json);

    const bool table = json != "-";
    InterruptGuard guard;
    const auto rows = run_stability(
        cases, request,
        [&](const StabilityRow& row) {
            if (table) write_output("-", [&](std::ostream& out) { out << stability_text(row); });
        },
        guard.requested());
    if (table) write_output("-", [&](std::ostream& out) { out << stability_summary(rows); });
    if (!json.empty()) write_output(json, [&](std::ostream& out) { out << stability_json(rows); });
    if (!arguments.output.empty()) {
        write_output(path_in(arguments.output, "stability.html"),
                     [&](std::ostream& out) { out << stability_page(rows); });
        write_output(path_in(arguments.output, "stability.json"),
                     [&](std::ostream& out) { out << stability_json(rows); });
        terminal.note("the page is in " + path_in(arguments.output, "stability.html"));
    }
    if (*guard.requested()) {
        terminal.note("interrupted; the report contains the cases that had finished");
        return exit_interrupted;
    }
    return std::all_of(rows.begin(), rows.end(), [](const StabilityRow& row) { return row.pass(); }) ? exit_done
                                                                                                     : exit_bound;
}

}  // namespace

const Verb stability_verb{"stability", "Run stiff and extreme cases with known results, and report which pass", declare,
                          run};

}  // namespace kagero
