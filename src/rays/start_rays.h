/// Conversion of rays from positions and directions to ray starts.
#pragma once

#include "plan/plan.h"

namespace kagero {

/// Position and direction at the start of a ray, in the coordinates of the scene file. The direction may have any
/// length.
struct RayInput {
    Double3 position, direction;
};

/// Returns the starts of rays. If an observer is given, the directions are those in its rest frame; otherwise, they are
/// directions of dq/dλ. For a falling observer, the plan must have been made with `falling` as Options::observer. If a
/// ray cannot start, RayStart::failure is the reason.
std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays,
                                 std::optional<ObserverKind> observer = {});

}  // namespace kagero
