/// Reader of the input of `trace`, a CSV table of rays.
#pragma once

#include "rays/start_rays.h"

#include <iosfwd>

namespace kagero {

/// Reads rays from CSV. The header names the columns x, y, z, dx, dy, dz in any order. `name` identifies the stream in
/// messages. Throws InputError with line and column if the text is not valid; throws RunError if the stream fails.
/// Infinities and NaN are accepted here; such rays end as `failed` when they are traced.
std::vector<RayInput> read_rays(std::istream& in, const std::string& name);

}  // namespace kagero
