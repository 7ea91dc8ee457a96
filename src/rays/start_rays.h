/// From rays as a caller gives them to canonical states.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// One ray: start and direction dq/dλ, of any length, in scene coordinates.
struct RayInput {
    Double3 position, direction;
};

/// Canonical states for rays; with an observer the directions are read in its rest frame. The plan must have been made
/// for a falling observer (Options::observer) if its rays are. A ray that cannot start has the reason in
/// RayStart::failure.
std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays,
                                 std::optional<ObserverKind> observer = {});

}  // namespace kagero
