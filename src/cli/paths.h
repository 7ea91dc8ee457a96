/// Output of ray paths, step by step.
#pragma once

#include "cli/terminal.h"
#include "plan/plan.h"
#include "render/run_report.h"

#include <string>

namespace kagero {

/// Traces the rays in batches (4096, or 256 if points are at even intervals), and writes their paths as CSV to
/// `output`; "-" is stdout. `with_bounces` adds the number of bounces and the medium of each point. Rays that cannot be
/// traced from their start have no path: a warning states their number, and the reason for the first of them. After an
/// interruption, only the rays that had ended are written.
void write_paths_of(const Plan& plan, const std::vector<RayStart>& starts, bool with_bounces, const std::string& output,
                    const RunControl& control, const Terminal& terminal);

}  // namespace kagero
