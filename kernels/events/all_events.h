/// The list of all events. A new event requires one new file in this folder and one new row in this list.
#pragma once

#include "kernels/events/capture.h"
#include "kernels/events/chart_sphere.h"
#include "kernels/events/discontinuity.h"
#include "kernels/events/escape_sphere.h"
#include "kernels/events/event_list.h"
#include "kernels/events/limits.h"
#include "kernels/events/medium_edge.h"
#include "kernels/events/surface_hit.h"
#include "kernels/events/turning_point.h"

namespace kagero {

/// All events, in the order in which a step is tested for them. If a step has crossed several events, its lane is
/// assigned the first of them in this list. Refinement may replace this event by one that lies earlier on the step.
// clang-format off
using AllEvents = EventList<
    SurfaceHit,
    ChartSphere,
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
