/// Writers of the output of `trace`: CSV tables of ray ends and of ray paths.
#pragma once

#include "appearance/path_state.h"
#include "plan/plan.h"

#include <iosfwd>
#include <string>

namespace kagero {

/// Returns a field of text, in quotes if it contains a comma, a quote or a line break.
std::string csv_text(const std::string& text);

/// Returns the reason why a ray failed or ended as `step_limit`; "" for other rays.
std::string reason_of(const Plan& plan, const RayEnd& end);

/// Returns the mean of the three weights of a path.
double mean_weight(const PathState& path);

/// Returns the header of write_ends.
std::string header_of_ends(const Plan& plan, bool with_paths = false);
/// Appends the row of a ray as write_ends writes it. `path` may be null.
void append_end(std::string& row, const Plan& plan, std::size_t ray, const RayEnd& end,
                const PathState* path = nullptr);
/// Writes the header and one row per ray. Numbers have 17 significant digits. The last columns are the integrals along
/// the ray that the plan requests, and, if `paths` is not null, the number of bounces, the medium at the end and the
/// mean of the three weights of each path.
void write_ends(std::ostream& out, const Plan& plan, const std::vector<RayEnd>& ends,
                const std::vector<PathState>* paths = nullptr);

/// Writes the header of the table of paths. `with_bounces` adds the number of bounces and the medium as last columns.
void write_path_header(std::ostream& out, const Plan& plan, bool with_bounces);
/// Writes one row per point. Numbers have 17 significant digits.
void write_paths(std::ostream& out, const Plan& plan, const std::vector<PathPoint>& points, bool with_bounces);

}  // namespace kagero
