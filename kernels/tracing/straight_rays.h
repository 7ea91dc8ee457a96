/// The short way of the tracing loop: straight rays meet the first surface, or the escape sphere, in closed form. One query, no step.
#pragma once

#include "kernels/tracing/loop.h"

namespace kagero {

/// Ends the active rays of a packet, but for those whose step does not lead out of the escape sphere: they come from beyond it and pass it
/// by, or their numbers do not fit.
template <class V>
void PacketTracer<V>::end_straight() {
    const Vec3<V> from = flow_.start.q(), v = flow_.start_velocity, to = advance(from, flow_.h, v);
    const std::uint64_t leaving = active_ & to_bits(leaves_space(to, v) & is_finite(sum_of_all(flow_.start, v)));
    flow_.end.set(to, flow_.start.p());
    flow_.end_velocity = v;
    const std::uint64_t hits = encounter_ ? encounter_->meet(flow_, leaving) : 0;
    const double radius = job_.escape_radius;
    const Level<double> sphere = sphere_level({0, 0, 0}, radius);
    for (std::uint64_t rest = leaving; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const Vec3<double> a = lane_of(from, i), b = lane_of(to, i);
        double fraction = -1;
        if ((hits >> i) & 1) {
            const double near = encounter_->from[i] + encounter_->t[i] * (encounter_->to[i] - encounter_->from[i]);
            fraction = chord_fraction(level_of(job_.geometry->surfaces[encounter_->surface[i]], encounter_->primitive[i]), a, b, near);
        }
        const Vec3<double> hit = a + fraction * (b - a);
        const bool on_surface = fraction >= 0 && dot(hit, hit) <= radius * radius;
        if (!on_surface) fraction = chord_fraction(sphere, a, b, 1);
        retire_straight(i, on_surface ? Status::hit : Status::escaped, a + fraction * (b - a), fraction);
        if (on_surface) ends_[i]->surface = encounter_->surface[i], ends_[i]->primitive = encounter_->primitive[i];
    }
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(leaving));
    active_ &= ~leaving;
    nominal_ = pick(from_bits<V>(leaving), V(S(0)), nominal_), flow_.h = pick(from_bits<V>(leaving), V(S(0)), flow_.h);
}

/// Writes the end of a straight ray that went a fraction of the step in the flow.
template <class V>
void PacketTracer<V>::retire_straight(int lane, Status status, const Vec3<double>& q, double fraction) {
    RayEnd& e = *ends_[lane];
    e = {};
    const Vec3<double> v = lane_of(flow_.start_velocity, lane), p = lane_of(flow_.start.p(), lane);
    const double inverse = 1 / norm(v);
    e.q[0] = q.x, e.q[1] = q.y, e.q[2] = q.z;
    e.p[0] = p.x, e.p[1] = p.y, e.p[2] = p.z;
    e.v[0] = v.x * inverse, e.v[1] = v.y * inverse, e.v[2] = v.z * inverse;
    e.pt = double(get_lane(flow_.start.y[6], lane));
    e.parameter = fraction * double(get_lane(flow_.h, lane));
    e.steps = 1, e.status = status;
    if (encounter_) e.queries = encounter_->queries_of(lane);
    counters_.steps += 1, counters_.queries += e.queries;
}

}  // namespace kagero
