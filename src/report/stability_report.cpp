#include "report/stability_report.h"

#include "report/json.h"

#include <algorithm>

namespace kagero {

namespace {

constexpr const char* page_head = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>kagero: stiff and extreme cases</title>
<style>
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 75rem; padding: 0 1rem; color: #222; background: #fff }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .4rem .6rem; border-bottom: 1px solid #ddd }
td:first-child { font-family: ui-monospace, monospace; white-space: nowrap }
.pass { color: #17662b } .fail { color: #b00020; font-weight: 600 }
@media (prefers-color-scheme: dark) {
  body { color: #ddd; background: #181818 } th, td { border-color: #444 } .pass { color: #7fd393 } .fail { color: #ff8a8a }
}
</style></head><body>
<h1>Stiff and extreme cases</h1>
)";

std::string escaped(const std::string& text) {
    std::string html;
    for (const char c : text) {
        if (c == '<')
            html += "&lt;";
        else if (c == '>')
            html += "&gt;";
        else if (c == '&')
            html += "&amp;";
        else
            html += c;
    }
    return html;
}

std::string verdict(bool pass) {
    return pass ? "pass" : "FAIL";
}

}  // namespace

std::string stability_text(const StabilityRow& row) {
    std::string text = verdict(row.pass()) + "  " + row.name + ": " + row.what + "\n      expected  " + row.expected + "\n";
    if (row.outcomes.size() == 1) return text + "      got       " + row.outcomes[0].got + "\n";
    for (const StabilityOutcome& outcome : row.outcomes) {
        std::string label = outcome.isa;
        label.resize(std::max(label.size(), std::size_t{8}), ' ');
        text += "      " + label + "  " + verdict(outcome.pass) + "  " + outcome.got + "\n";
    }
    return text;
}

std::string stability_summary(const std::vector<StabilityRow>& rows) {
    const auto passed = std::count_if(rows.begin(), rows.end(), [](const StabilityRow& row) { return row.pass(); });
    return std::to_string(passed) + " of " + std::to_string(rows.size()) + " cases pass\n";
}

std::string stability_json(const std::vector<StabilityRow>& rows) {
    Json cases = Json::array();
    for (const StabilityRow& row : rows) {
        Json isas = Json::array();
        std::string got;
        for (const StabilityOutcome& outcome : row.outcomes) {
            isas.push_back({{"isa", outcome.isa}, {"got", outcome.got}, {"pass", outcome.pass}});
            got += row.outcomes.size() == 1 ? outcome.got : (got.empty() ? "" : "; ") + outcome.isa + ": " + outcome.got;
        }
        cases.push_back({{"name", row.name}, {"what", row.what}, {"expected", row.expected}, {"got", got}, {"pass", row.pass()}, {"isas", isas}});
    }
    return text_of(Json{{"cases", cases}});
}

std::string stability_page(const std::vector<StabilityRow>& rows) {
    std::string page = page_head + ("<p>" + stability_summary(rows)) + "</p>\n<table><tr><th>case</th><th>what</th><th>expected</th>";
    if (!rows.empty())
        for (const StabilityOutcome& outcome : rows[0].outcomes) page += "<th colspan=\"2\">" + escaped(outcome.isa) + "</th>";
    page += "</tr>\n";
    for (const StabilityRow& row : rows) {
        page += "<tr><td>" + escaped(row.name) + "</td><td>" + escaped(row.what) + "</td><td>" + escaped(row.expected) + "</td>";
        for (const StabilityOutcome& outcome : row.outcomes) {
            const std::string kind = outcome.pass ? "pass" : "fail";
            page += "<td class=\"" + kind + "\">" + kind + "</td><td>" + escaped(outcome.got) + "</td>";
        }
        page += "</tr>\n";
    }
    return page + "</table>\n</body></html>\n";
}

}  // namespace kagero
