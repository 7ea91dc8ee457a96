/// What a page offers to change: the parameters of the space with their ranges, the formula, the camera and the layers.
#pragma once

#include "modules/space.h"
#include "report/json.h"
#include "scene/description.h"

namespace kagero {

/// Returns the description of a scene for a page. `info` describes its Hamiltonian.
Json controls_json(const SceneDescription& scene, const HamiltonianInfo& info);

}  // namespace kagero
