/// `trace`'s tables of ends and of paths.
#pragma once

#include "plan/plan.h"

#include <iosfwd>

namespace kagero {

/// One row per ray, 17 significant digits.
void write_ends(std::ostream& out, const Plan& plan, const std::vector<RayEnd>& ends);

/// The table of steps: its first line, and a row per step.
void write_path_header(std::ostream& out);
void write_paths(std::ostream& out, const std::vector<PathPoint>& points);

}  // namespace kagero
