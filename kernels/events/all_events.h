/// The list of all events. One more event is one more file in this folder and one more row here.
#pragma once

#include "kernels/events/capture.h"
#include "kernels/events/discontinuity.h"
#include "kernels/events/escape_sphere.h"
#include "kernels/events/event_list.h"
#include "kernels/events/limits.h"
#include "kernels/events/medium_edge.h"
#include "kernels/events/surface_hit.h"
#include "kernels/events/turning_point.h"

namespace kagero {

/// In the order in which a step is tested for them. A lane takes the first one that it has crossed, until refinement
/// finds an earlier one.
// clang-format off
using AllEvents = EventList<
    SurfaceHit,
    MediumEdge,
    TurningPoint,
    EscapeSphere,
    SecondEscapeSphere,
    Capture,
    ParameterLimit,
    StepLimit,
    Discontinuity>;
// clang-format on

}  // namespace kagero
