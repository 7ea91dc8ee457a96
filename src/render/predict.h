/// Prediction of the costs of tiles before they are traced.
#pragma once

#include "render/run.h"

namespace kagero {

/// Writes to `work.costs` the predicted costs of rendering the tiles to `film`, in floating-point operations. Traces
/// one ray per 11 × 11 pixels, at least one per tile, and counts its gradients, steps and queries. If the film needs
/// footprints on the sky, traces four rays per 16 × 16 pixels and also counts their probes of the sky's image. The
/// costs stay unchanged if the prediction is interrupted or takes more than a tenth of the time limit.
void predict_costs(const Plan& plan, const Film& film, WorkList& work, const RunControl& control);

}  // namespace kagero
