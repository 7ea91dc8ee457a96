/// What tiles will cost, before they are traced.
#pragma once

#include "render/run.h"

namespace kagero {

/// Writes what tiles will cost when `film` is rendered, in floating-point operations: follows a ray for every 11 × 11
/// pixels, at least one per tile, and counts its gradients, steps and queries; where a sky has an image four for every
/// 16 × 16, and the places of that they would look up. Ended early, or after a tenth of the time there is, it leaves
/// them as they were.
void predict_costs(const Plan& plan, const Film& film, WorkList& work, const Watch& watch);

}  // namespace kagero
