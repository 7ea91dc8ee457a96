/// The table of every step of rays.
#pragma once

#include "cli/terminal.h"
#include "plan/plan.h"
#include "render/run_report.h"

#include <string>

namespace kagero {

/// Follows the rays, some thousands at a time, and writes their steps to `output`, "-" for stdout. Rays that end where
/// they start have none: a warning says how many, and why the first. After an interruption: the rays that were followed
/// to their ends.
void write_paths_of(const Plan& plan, const std::vector<RayStart>& starts, const std::string& output,
                    const Watch& watch, const Terminal& terminal);

}  // namespace kagero
