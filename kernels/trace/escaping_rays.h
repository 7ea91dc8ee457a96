/// Fast path for rays that cannot meet a surface: the stepper integrates them to the escape sphere, or until they are
/// captured, without the tracing loop. Captured rays end at the last state before their capture. If their capture must
/// lie within Job::capture_radius, the loop completes them, and also rays with many revolutions.
#pragma once

#include "kernels/events/capture.h"
#include "kernels/trace/ray_end_writer.h"

#include <algorithm>
#include <limits>

namespace kagero {

/// Integrates the active rays of a packet to the escape sphere as far as the stepper can. Returns the lanes whose rays
/// have ended. Sets `moving` to the lanes whose rays have reached a valid state: finite and with conserved H.
template <class V>
std::uint64_t integrate_to_escape(const Task<V>& task, Packet<V>& packet, RayEndWriter<V>& writer, Counters& counters,
                                  std::uint64_t& moving) {
    using S = ScalarOf<V>;
    constexpr std::uint32_t max_steps = 4096;  // a limit, because a job cannot be cancelled during the integration
    StepperState<V>& state = packet.state;
    EscapeIntegration<V> integration;
    // Rays that start outside the sphere may pass it without entering, so the loop integrates them.
    integration.h = select(is_outside(task, state.start.q()), V(S(0)), packet.step_length);
    integration.radius = task.job.escape_radius;
    integration.max_steps = std::min(task.job.max_steps, max_steps);
    integration.ends_captured = task.job.capture_radius == std::numeric_limits<double>::infinity();
    integration.captured = no_lanes<V>();
    task.integrate_to_escape(state, integration);
    moving = packet.active & to_bits(is_finite(sum_of_all(state.end, state.end.velocity)) & state.energy_is_conserved);
    const MaskOf<V> mask = from_bits<V>(moving);
    packet.steps = select(mask, integration.steps, packet.steps);
    packet.worst_energy_error = select(mask, state.energy_error, packet.worst_energy_error);
    const std::uint64_t escaped = moving & to_bits(integration.arrived),
                        captured = moving & to_bits(integration.captured);
    counters.issued_lane_steps += integration.issued_steps * Packet<V>::W;
    counters.active_lane_steps += integration.active_lane_steps;
    writer.end_rays(state, escaped, EscapeSphere::status);
    writer.end_rays(state, captured, Capture::status);
    return escaped | captured;
}

}  // namespace kagero
