/// `trace`'s table of rays.
#pragma once

#include "rays/start_rays.h"

#include <iosfwd>

namespace kagero {

/// Reads rays from CSV with a header naming the columns x, y, z, dx, dy, dz in any order. `name` stands for the stream
/// in messages. Throws InputError with the place of what does not parse. Infinities and NaN parse: what cannot be
/// traced fails later, ray by ray.
std::vector<RayInput> read_rays(std::istream& in, const std::string& name);

}  // namespace kagero
