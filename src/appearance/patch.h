/// Colours, and the pieces of sky and of surfaces that rays stand for.
#pragma once

#include "scene/description.h"

namespace kagero {

using Float3 = std::array<float, 3>;

/// A small ellipse of directions: its axes, at right angles to each other, with their full lengths in radians.
struct Footprint {
    Double3 major{}, minor{};
};

/// The piece of a surface that a ray stands for: where its end moves to from one ray to the next on its right, and
/// below it; scene lengths.
struct Patch {
    Double3 right{}, below{};
};

}  // namespace kagero
