// kagero stability: compares stiff and extreme cases with results known from theory.
#include "stability/stability.h"

#include "cli/interrupt.h"
#include "cli/output.h"
#include "cli/verb.h"
#include "error.h"
#include "modules/modules.h"
#include "parts/journals/entry_journal.h"
#include "plan/names.h"
#include "report/stability_report.h"

#include <algorithm>
#include <optional>
#include <ostream>

namespace kagero {

namespace {

void declare_stability(CLI::App& app, Arguments& arguments) {
    add_option(app, "CASE", arguments.cases, "Names of the cases to run. Default: all cases", "");
    add_option(app, "-o,--output", arguments.output,
               "Directory for stability.html and stability.json. Default: no files are written", "DIR");
    add_flag(app, "--resume", arguments.resume,
             "Keep the results of finished cases in DIR/stability.journal, and continue from it if it exists. The "
             "journal is removed when all cases have finished. Requires -o");
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

/// Returns what must be the same for a run that continues.
Properties identity_of_request(const std::vector<std::string>& cases, const StabilityRequest& request) {
    std::string isas, precisions, strategies, chosen;
    for (const std::string& isa : request.isas) append_to_list(isas, load_module(isa).isa);
    for (const Precision precision : request.precisions) append_to_list(precisions, name_of(precision));
    for (const Strategy strategy : request.strategies) append_to_list(strategies, name_of(strategy));
    for (const std::string& name : cases) append_to_list(chosen, name);
    return {{"the version of kagero", KAGERO_VERSION},
            {"the compiler", load_module(request.isas.front()).compiler},
            {"the list of cases", chosen.empty() ? "all" : chosen},
            {"the list of instruction sets", isas},
            {"the list of precisions", precisions},
            {"the list of strategies", strategies}};
}

/// Runs one case, or returns its result from the journal.
std::vector<StabilityRow> run_or_read(const std::string& name, const StabilityRequest& request,
                                      std::optional<EntryJournal>& journal, const std::atomic<bool>* stop) {
    if (journal)
        if (const Json* entry = journal->find(name)) return {stability_row(*entry)};
    std::vector<StabilityRow> rows = run_stability({name}, request, {}, stop);
    if (journal && !rows.empty()) journal->append(name, stability_entry(rows.front()));
    return rows;
}

/// Runs the cases in the order of their table, without those that the journal contains.
std::vector<StabilityRow> run_cases(const std::vector<std::string>& cases, const StabilityRequest& request,
                                    std::optional<EntryJournal>& journal,
                                    const std::function<void(const StabilityRow&)>& done,
                                    const std::atomic<bool>* stop) {
    std::vector<StabilityRow> rows;
    for (const std::string& name : stability_case_names()) {
        if (!cases.empty() && std::find(cases.begin(), cases.end(), name) == cases.end()) continue;
        if (*stop) break;
        for (StabilityRow& row : run_or_read(name, request, journal, stop)) {
            done(row);
            rows.push_back(std::move(row));
        }
    }
    return rows;
}

int run_stability(const Arguments& arguments, const Terminal& terminal) {
    std::vector<std::string> cases = arguments.cases;
    std::string json = arguments.json;
    restore_case(cases, json);
    require_cases(cases);
    const StabilityRequest request = request_of(arguments);
    std::optional<ReportDirectory> directory;
    if (arguments.resume && arguments.output.empty())
        throw InputError("--resume keeps its journal in the directory of the report; state it with -o DIR");
    if (arguments.output.empty()) check_outputs({{"--json", json}});
    else directory.emplace(arguments.output, std::vector<std::string>{"stability.html", "stability.json"}, json);
    std::optional<EntryJournal> journal;
    if (arguments.resume)
        journal.emplace(path_in(arguments.output, "stability.journal"), identity_of_request(cases, request));

    const bool table = json != "-";
    InterruptGuard guard;
    const auto rows = run_cases(
        cases, request, journal,
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
        terminal.note(journal
                          ? "interrupted; the finished cases are in " + journal->path() + "; the same command continues"
                          : "interrupted; the report contains the cases that had finished");
        return exit_interrupted;
    }
    if (journal) journal->remove();
    return std::all_of(rows.begin(), rows.end(), [](const StabilityRow& row) { return row.pass(); }) ? exit_done
                                                                                                     : exit_bound;
}

}  // namespace

const Verb stability_verb{"stability", "Run stiff and extreme cases with known results, and report which pass",
                          declare_stability, run_stability};

}  // namespace kagero
