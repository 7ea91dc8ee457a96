/// The other short way of the tracing loop: rays that meet nothing, led by their stepper to the escape sphere. What it leaves undone, the
/// last step of a ray that is captured above all, and rays that go round and round, the loop does.
#pragma once

#include "kernels/trace/loop.h"

#include <algorithm>

namespace kagero {

/// Steps that nobody can interrupt.
constexpr std::uint32_t most_at_once = 4096;

template <class V>
void PacketTracer<V>::pass() {
    Passage<V> way;
    // From beyond the sphere a ray may pass it by.
    way.h = pick(is_beyond(flow_.start.q()), V(S(0)), nominal_), way.radius = job_.escape_radius;
    way.max_steps = std::min(job_.max_steps, most_at_once);
    task_.pass(flow_, way);
    const std::uint64_t usable = active_ & to_bits(is_finite(sum_of_all(flow_.end, flow_.end.velocity)) & flow_.energy_holds);
    const MaskOf<V> here = from_bits<V>(usable);
    steps_ = pick(here, way.steps, steps_);
    worst_energy_ = pick(here, flow_.energy_error, worst_energy_);
    const std::uint64_t arrived = usable & to_bits(way.arrived);
    counters_.issued_lane_steps += way.issued_steps * W, counters_.active_lane_steps += way.active_lane_steps;
    retire(flow_, arrived, Status::escaped);
    if (active_ == arrived) active_ = 0;
    else commit(usable, usable & ~arrived);
    note_direction(usable);
}

}  // namespace kagero
