/// Reports of the stability cases, as text, JSON and an HTML page.
#pragma once

#include "report/json.h"
#include "stability/stability.h"

#include <string>
#include <vector>

namespace kagero {

/// Returns one case as text: "pass" or "FAIL", name and description. The lines below contain the expected result and
/// the result on each instruction set.
std::string stability_text(const StabilityRow& row);
/// Returns a line with the number of cases that pass and the number of all cases.
std::string stability_summary(const std::vector<StabilityRow>& rows);
/// Returns the JSON of `stability`.
std::string stability_json(const std::vector<StabilityRow>& rows);
/// Returns one case as an object of the JSON of `stability`.
Json stability_entry(const StabilityRow& row);
/// Returns the case of which stability_entry returned `entry`.
StabilityRow stability_row(const Json& entry);
/// Returns one self-contained HTML page.
std::string stability_page(const std::vector<StabilityRow>& rows);

}  // namespace kagero
