#include "report/stability_report.h"

#include "report/json.h"
#include "report/text/page.h"

#include <algorithm>

namespace kagero {

namespace {

std::string verdict(bool pass) { return pass ? "pass" : "FAIL"; }

}  // namespace

std::string stability_text(const StabilityRow& row) {
    std::string text =
        verdict(row.pass()) + "  " + row.name + ": " + row.description + "\n      expected  " + row.expected + "\n";
    if (row.outcomes.size() == 1) return text + "      got       " + row.outcomes[0].result + "\n";
    for (const StabilityOutcome& outcome : row.outcomes) {
        std::string label = outcome.isa;
        label.resize(std::max(label.size(), std::size_t{8}), ' ');
        text += "      " + label + "  " + verdict(outcome.pass) + "  " + outcome.result + "\n";
    }
    return text;
}

std::string stability_summary(const std::vector<StabilityRow>& rows) {
    const auto passed = std::count_if(rows.begin(), rows.end(), [](const StabilityRow& row) { return row.pass(); });
    return std::to_string(passed) + " of " + std::to_string(rows.size()) + " cases pass\n";
}

Json stability_entry(const StabilityRow& row) {
    Json isas = Json::array();
    std::string results;
    for (const StabilityOutcome& outcome : row.outcomes) {
        isas.push_back({{"isa", outcome.isa}, {"got", outcome.result}, {"pass", outcome.pass}});
        results += row.outcomes.size() == 1 ? outcome.result
                                            : (results.empty() ? "" : "; ") + outcome.isa + ": " + outcome.result;
    }
    return {{"name", row.name}, {"what", row.description}, {"expected", row.expected},
            {"got", results},   {"pass", row.pass()},      {"isas", isas}};
}

StabilityRow stability_row(const Json& entry) {
    StabilityRow row{entry["name"], entry["what"], entry["expected"], {}};
    for (const Json& outcome : entry["isas"]) row.outcomes.push_back({outcome["isa"], outcome["got"], outcome["pass"]});
    return row;
}

std::string stability_json(const std::vector<StabilityRow>& rows) {
    Json cases = Json::array();
    for (const StabilityRow& row : rows) cases.push_back(stability_entry(row));
    return text_of(Json{{"cases", cases}});
}

std::string stability_page(const std::vector<StabilityRow>& rows) {
    std::vector<std::string> head{"case", "description", "expected"};
    if (!rows.empty())
        for (const StabilityOutcome& outcome : rows[0].outcomes)
            head.insert(head.end(), {html_text(outcome.isa), "got"});
    std::vector<std::vector<std::string>> cells;
    for (const StabilityRow& row : rows) {
        cells.push_back({html_text(row.name), html_text(row.description), html_text(row.expected)});
        for (const StabilityOutcome& outcome : row.outcomes)
            cells.back().insert(cells.back().end(),
                                {outcome.pass ? "pass" : "<span class=\"bad\">FAIL</span>", html_text(outcome.result)});
    }
    return html_page("Stiff and extreme cases", stability_summary(rows), html_table(head, cells, head.size()));
}

}  // namespace kagero
