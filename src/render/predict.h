/// What tiles will cost, before they are traced.
#pragma once

#include "render/schedule.h"

#include <atomic>

namespace kagero {

/// Follows a ray for every 16 × 16 pixels, at least one per tile, and writes the costs of the tiles: the rays of each, times what
/// one of them takes. The unit is about the time of a gradient.
void predict_costs(const Plan& plan, WorkList& work, const std::atomic<bool>* stop = nullptr);

}  // namespace kagero
