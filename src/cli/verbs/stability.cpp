// kagero stability: stiff and extreme cases against theory.
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
    add_option(app, "CASE", arguments.cases, "The cases to run; default: all", "");
    add_option(app, "-o,--output", arguments.output, "A directory for stability.html and stability.json", "DIR");
    add_isa(app, arguments, true);
    add_json(app, arguments);
    add_machine(app, arguments);
    add_messages(app, arguments);
}

StabilityRequest request_of(const Arguments& arguments) {
    const Options options = options_of(arguments);
    if (options.strategy == Strategy::per_ray)
        throw InputError(
            "--strategy: per-ray kernels are compiled for a few spaces alone; the cases run by packet and scalar ones");
    StabilityRequest request;
    request.isas = isas_for(options.isa), request.threads = options.threads;
    if (options.precision) request.precisions = {*options.precision};
    if (options.strategy) request.strategies = {*options.strategy};
    return request;
}

void return_case_json_took(std::vector<std::string>& cases, std::string& json) {
    if (!json_took_word(json, stability_case_names(), "a case")) return;
    cases.push_back(json);
    json = "-";
}

int run(const Arguments& arguments, const Terminal& terminal) {
    std::vector<std::string> cases = arguments.cases;
    std::string json = arguments.json;
    return_case_json_took(cases, json);
    require_cases(cases);
    const StabilityRequest request = request_of(arguments);
    std::optional<ReportDirectory> made;
    if (arguments.output.empty()) check_outputs({{"--json", json}});
    else made.emplace(arguments.output, std::vector<std::string>{"stability.html", "stability.json"}, json);

    const bool table = json != "-";
    InterruptGuard guard;
    const auto rows = run_stability(cases, request, [&](const StabilityRow& row) {
        if (table) write_output("-", [&](std::ostream& out) { out << stability_text(row); });
    }, guard.requested());
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
        terminal.note("interrupted; the cases that were done are told");
        return exit_interrupted;
    }
    return std::all_of(rows.begin(), rows.end(), [](const StabilityRow& row) { return row.pass(); }) ? exit_done
                                                                                                     : exit_bound;
}

}  // namespace

const Verb stability_verb{"stability", "Run stiff and extreme cases, and say which hold", declare, run};

}  // namespace kagero
