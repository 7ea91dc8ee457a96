/// `trace`'s tables: rays in, ends or paths out.
#pragma once

#include "render/render.h"

#include <iosfwd>

namespace kagero {

/// Reads rays from CSV with a header naming the columns x, y, z, dx, dy, dz in any order. `name` stands for the stream in
/// messages. Throws InputError with the place of what does not parse. Infinities and NaN parse: what cannot be traced fails
/// later, ray by ray.
std::vector<RayInput> read_rays(std::istream& in, const std::string& name);

/// One row per ray, 17 significant digits.
void write_ends(std::ostream& out, const Plan& plan, const std::vector<RayEnd>& ends);

/// The table of steps: its first line, and a row per step.
void write_path_header(std::ostream& out);
void write_paths(std::ostream& out, const std::vector<PathPoint>& points);

}  // namespace kagero
