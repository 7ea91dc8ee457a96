/// Writers of the output of `trace`: CSV tables of ray ends and of ray paths.
#pragma once

#include "plan/plan.h"

#include <iosfwd>

namespace kagero {

/// Writes the header and one row per ray. Numbers have 17 significant digits. The last columns are the integrals along
/// the ray that the plan requests.
void write_ends(std::ostream& out, const Plan& plan, const std::vector<RayEnd>& ends);

/// Writes the header of the table of paths.
void write_path_header(std::ostream& out, const Plan& plan);
/// Writes one row per point. Numbers have 17 significant digits.
void write_paths(std::ostream& out, const Plan& plan, const std::vector<PathPoint>& points);

}  // namespace kagero
