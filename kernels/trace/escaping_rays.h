/// The short way for rays that meet nothing: the stepper itself integrates them to the escape sphere. What it leaves
/// over, mostly the last step of a captured ray and rays that wind around many times, the loop integrates.
#pragma once

#include "kernels/trace/ray_end_writer.h"

#include <algorithm>

namespace kagero {

/// Integrates the active rays of a packet to the escape sphere where that can be done; returns the lanes whose rays
/// have ended, and in `moving` those that have moved.
template <class V>
std::uint64_t integrate_to_escape(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer, Counters& counters,
                                  std::uint64_t& moving) {
    using S = ScalarOf<V>;
    constexpr std::uint32_t max_steps = 4096;  // no step of it can be interrupted
    StepperState<V>& state = packet.state;
    EscapeIntegration<V> way;
    // A ray from beyond the sphere may pass it.
    way.h = select(is_outside(task, state.start.q()), V(S(0)), packet.step_length), way.radius = task.job.escape_radius;
    way.max_steps = std::min(task.job.max_steps, max_steps);
    task.integrate_to_escape(state, way);
    moving = packet.active & to_bits(is_finite(sum_of_all(state.end, state.end.velocity)) & state.energy_holds);
    const MaskOf<V> here = from_bits<V>(moving);
    packet.steps = select(here, way.steps, packet.steps);
    packet.worst_energy = select(here, state.energy_error, packet.worst_energy);
    const std::uint64_t escaped = moving & to_bits(way.arrived);
    counters.issued_lane_steps += way.issued_steps * Packet<V>::W, counters.active_lane_steps += way.active_lane_steps;
    writer.end_rays(state, escaped, EscapeSphere::status);
    return escaped;
}

}  // namespace kagero
