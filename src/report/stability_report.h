/// The stability cases as a table, JSON and a page.
#pragma once

#include "stability/stability.h"

#include <string>
#include <vector>

namespace kagero {

/// One row as text: verdict, name, what; below it what was expected, and what was got on each instruction set.
std::string stability_text(const StabilityRow& row);
/// How many passed.
std::string stability_summary(const std::vector<StabilityRow>& rows);
std::string stability_json(const std::vector<StabilityRow>& rows);
/// One self-contained HTML page.
std::string stability_page(const std::vector<StabilityRow>& rows);

}  // namespace kagero
