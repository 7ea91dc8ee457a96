/// The short way of the tracing loop: straight rays meet the first surface, or the escape sphere, in closed form. One query, no step.
#pragma once

#include "kernels/trace/loop.h"

namespace kagero {

/// Ends the active rays of a packet, but for those whose step does not lead out of the escape sphere: they come from beyond it and pass it
/// by, or their numbers do not fit.
template <class V>
void PacketTracer<V>::end_straight() {
    const V way = straight_way_out();
    const Vec3<V> from = flow_.start.q(), v = flow_.start.velocity, to = advance(from, way, v);
    const std::uint64_t leaving = active_ & to_bits(leaves_space(to, v) & is_finite(sum_of_all(flow_.start, v)));
    std::uint64_t hits = encounter_ ? encounter_->meet_straight(from, to, leaving) : 0;
    V fraction(S(0));
    if (hits) {
        std::copy_n(encounter_->surface, W, surface_), std::copy_n(encounter_->primitive, W, primitive_);
        fraction = chord_fraction(encounter_->levels(hits), from, to, encounter_->t);
        hits &= ~to_bits(is_beyond(advance(from, fraction, to - from)) | (fraction < V(S(0))));
    }
    if (hits != leaving)
        fraction = pick(from_bits<V>(hits), fraction, chord_fraction(sphere_level(V(S(job_.escape_radius))), from, to, V(S(1))));
    flow_.end.set(advance(from, fraction, to - from), flow_.start.p());
    flow_.end.velocity = v;
    flow_.end.parameter = fraction * way;
    steps_ = pick(from_bits<V>(leaving), V(S(1)), steps_);
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(leaving));
    retire(flow_, hits, Status::hit);
    retire(flow_, leaving & ~hits, Status::escaped);
    active_ &= ~leaving;
    if (active_) set_out(filled_);
}

}  // namespace kagero
