/// The choice of the algorithm that computes the ends of the rays of a task.
#pragma once

#include "kernels/events/all_events.h"

namespace kagero {

/// The algorithm that computes the ends of rays.
enum class TraceAlgorithm {
    steps,        ///< The tracing loop.
    closed_form,  ///< `end_straight_rays`, for straight rays.
    to_escape,    ///< `integrate_to_escape`, for rays that cannot meet a surface.
};

/// Returns the fastest algorithm that handles all events of the task.
template <class Events, class V>
TraceAlgorithm trace_algorithm_of(const Task<V>& task) {
    if (task.job.path_sink) return TraceAlgorithm::steps;
    if (task.straight) {
        const bool has_closed_form =
            Events::template exist_only<SurfaceHit, TurningPoint, EscapeSphere, Capture, StepLimit, Discontinuity>(
                task);
        return has_closed_form ? TraceAlgorithm::closed_form : TraceAlgorithm::steps;
    }
    const bool meets_no_surface =
        Events::template exist_only<MediumEdge, TurningPoint, EscapeSphere, SecondEscapeSphere, Capture, StepLimit,
                                    Discontinuity, ChartSphere>(task);
    const bool is_regular = !ChartSphere::exists(task) || task.regular_in_both_charts;
    const bool to_escape = meets_no_surface && is_regular && task.can_integrate_to_escape() &&
                           !(task.job.outputs & output_integrals);
    return to_escape ? TraceAlgorithm::to_escape : TraceAlgorithm::steps;
}

}  // namespace kagero
