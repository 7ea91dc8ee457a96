/// Keeps rays near a spinning black hole in the chart in which they are regular (kernels/events/chart_sphere.h).
#pragma once

#include "kernels/events/chart_sphere.h"
#include "kernels/trace/path_recorder.h"
#include "kernels/trace/ray_loader.h"

namespace kagero {

/// Changes the chart of those active rays of `lanes` that are not regular in their chart. Returns their lanes; their
/// next steps have to be started.
template <class V, class Events>
std::uint64_t correct_charts(const Task<V>& task, Packet<V>& packet, RayLoader<V, Events>& loader,
                             PathRecorder<V>& recorder, std::uint64_t lanes) {
    StepperState<V>& state = packet.state;
    const std::uint64_t wrong = lanes_in_wrong_chart(task, state, lanes & packet.active);
    if (!wrong) return 0;
    RayState<V> start = state.start;
    recorder.change_chart(start, wrong & state.ingoing, true, true);
    recorder.change_chart(start, wrong & ~state.ingoing, false, false);
    change_chart(task.job, start, wrong & state.ingoing, true);
    change_chart(task.job, start, wrong & ~state.ingoing, false);
    state.ingoing ^= wrong;
    packet.iterations_of_ray = select(from_bits<V>(wrong), state.lane_iterations, packet.iterations_of_ray);
    loader.resume(start, state, wrong);
    return wrong;
}

}  // namespace kagero
