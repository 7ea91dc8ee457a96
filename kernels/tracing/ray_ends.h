/// The end of the tracing loop: lanes that wait to be delivered, and what is written of a ray when it ends and after each of its steps.
#pragma once

#include "kernels/tracing/loop.h"

namespace kagero {

/// Hits become waiting lanes, except those that lie beyond the escape sphere.
template <class V>
std::uint64_t PacketTracer<V>::wait_for_surface(Landing<V>& landing, std::uint64_t hits) {
    if (!hits) return 0;
    const Encounter<V>& encounter = *encounter_;
    const Curve<V> curve = task_.curve(flow_);
    V from(S(0)), to(S(1));
    for (std::uint64_t rest = hits; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        set_lane(from, i, S(encounter.from[i])), set_lane(to, i, S(encounter.to[i]));
    }
    const Vec3<V> a = curve.at(from), b = curve.at(to);
    std::uint64_t accepted = 0;
    for (std::uint64_t rest = hits; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const Vec3<double> a1 = lane_of(a, i), b1 = lane_of(b, i), hit = a1 + encounter.t[i] * (b1 - a1);
        const double square = dot(hit, hit), inner = job_.inner_escape_radius;
        if (square > job_.escape_radius * job_.escape_radius || square < inner * inner) continue;
        const Level<double> level = level_of(job_.geometry->surfaces[encounter.surface[i]], encounter.primitive[i]);
        const double lo = encounter.from[i], hi = encounter.to[i];
        landing.wait(i, level, lo, hi, lo + (hi - lo) * chord_fraction(level, a1, b1, encounter.t[i]));
        surface_[i] = encounter.surface[i], primitive_[i] = encounter.primitive[i];
        accepted |= std::uint64_t(1) << i;
    }
    if (accepted) landing.take(flow_, accepted);
    fell_on_surface_ |= accepted;
    return accepted;
}

template <class V>
void PacketTracer<V>::wait_for_sphere(Landing<V>& landing, std::uint64_t lanes) {
    const Vec3<V> a = flow_.start.q(), b = flow_.end.q();
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const Vec3<double> from = lane_of(a, i), to = lane_of(b, i);
        const Level<double> sphere = sphere_level({0, 0, 0}, dot(to, to) < dot(from, from) ? job_.inner_escape_radius : job_.escape_radius);
        landing.wait(i, sphere, 0, 1, chord_fraction(sphere, from, to, 1));
    }
    landing.take(flow_, lanes);
}

template <class V>
void PacketTracer<V>::land(Landing<V>& landing) {
    if (!landing.waiting) return;
    const Stopwatch watch(job_.timed, counters_.landing_ticks);
    landing.land();
    if (flow_.want_energy) worst_energy_ = max(worst_energy_, landing.flow.energy_error);
    const std::uint64_t there = landing.waiting & ~landing.lost, hits = there & fell_on_surface_, captured = there & landing.captured;
    retire(landing.flow, landing.waiting & landing.lost, Status::failed, Failure::not_converged);
    retire(landing.flow, hits, Status::hit);
    retire(landing.flow, captured, Status::captured);
    retire(landing.flow, there & ~(hits | captured), Status::escaped);
    for (std::uint64_t rest = landing.waiting; rest; rest &= rest - 1) tell_iterations(__builtin_ctzll(rest), iterations_after_);
    for (std::uint64_t rest = there; rest; rest &= rest - 1) ends_[__builtin_ctzll(rest)]->unrefined = (landing.unrefined >> __builtin_ctzll(rest)) & 1;
    for (std::uint64_t rest = hits; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        ends_[i]->surface = surface_[i], ends_[i]->primitive = primitive_[i];
    }
}

/// Ends a ray that starts so far out that its numbers may not fit the packet's.
template <class V>
void PacketTracer<V>::retire_far_out(const RayStart& start, int lane) {
    retire(flow_, std::uint64_t(1) << lane, Status::escaped);
    RayEnd& e = *ends_[lane];
    const double inverse = 1 / norm(Vec3<double>{start.p[0], start.p[1], start.p[2]});
    for (int k = 0; k < 3; ++k) e.q[k] = start.q[k], e.p[k] = start.p[k], e.v[k] = start.p[k] * inverse;
    e.pt = start.pt, e.parameter = e.energy_error = 0;
}

/// Writes the ends of the rays of `lanes` from the end of the step in `f`.
template <class V>
void PacketTracer<V>::retire(const Flow<V>& f, std::uint64_t lanes, Status status, Failure failure) {
    if (!lanes) return;
    const V square = dot(f.end_velocity, f.end_velocity), inverse = V(S(1)) / sqrt(square);
    const V usable = pick(is_finite(inverse), inverse, V(S(0)));
    const Vec3<V> along = usable * f.end_velocity;
    for (; lanes; lanes &= lanes - 1) {
        const int i = __builtin_ctzll(lanes);
        RayEnd& e = *ends_[i];
        const Vec3<double> v = lane_of(along, i);
        for (int k = 0; k < 3; ++k) e.q[k] = double(get_lane(f.end.y[k], i)), e.p[k] = double(get_lane(f.end.y[3 + k], i));
        e.v[0] = v.x, e.v[1] = v.y, e.v[2] = v.z;
        e.pt = double(get_lane(f.start.y[6], i));
        e.parameter = double(get_lane(f.end_parameter, i));
        e.energy_error = double(get_lane(worst_energy_, i));
        e.steps = static_cast<std::uint32_t>(get_lane(steps_, i));
        e.gradients = static_cast<std::uint32_t>(get_lane(f.gradients, i));
        tell_iterations(i, flow_.open_iterations);
        e.queries = encounter_ ? encounter_->queries_of(i) : 0;
        e.occupancy = 0, e.surface = e.primitive = 0;
        e.status = status, e.failure = failure, e.unrefined = false;
        counters_.steps += e.steps, counters_.gradients += e.gradients, counters_.queries += e.queries;
        if (job_.path_sink && e.steps > 0) report_path(f, std::uint64_t(1) << i, false);
    }
}

template <class V>
void PacketTracer<V>::tell_iterations(int lane, const V& now) {
    ends_[lane]->iterations = static_cast<std::uint32_t>(get_lane(now, lane) - get_lane(iterations_before_, lane));
}

/// Tells the rays of lanes how full their packet was; not part of what ends a ray, because the packet goes on without it.
template <class V>
void PacketTracer<V>::tell_occupancy(std::uint64_t lanes) {
    const std::uint64_t issued = counters_.issued_lane_steps - issued_before_;
    const float occupancy = issued > 0 ? float(double(counters_.active_lane_steps - active_before_) / double(issued)) : 0;
    for (; lanes; lanes &= lanes - 1) ends_[__builtin_ctzll(lanes)]->occupancy = occupancy;
}

template <class V>
void PacketTracer<V>::report_path(const Flow<V>& f, std::uint64_t lanes, bool at_start) {
    if (!job_.path_sink) return;
    const State<V>& state = at_start ? f.start : f.end;
    const Vec3<V>& velocity = at_start ? f.start_velocity : f.end_velocity;
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        PathPoint point{};
        point.ray = numbers_[i], point.step = at_start ? 0 : static_cast<std::uint32_t>(get_lane(steps_, i));
        point.parameter = double(get_lane(at_start ? f.start_parameter : f.end_parameter, i));
        for (int k = 0; k < 3; ++k) point.q[k] = double(get_lane(state.y[k], i)), point.p[k] = double(get_lane(state.y[3 + k], i));
        const Vec3<double> v = lane_of(velocity, i);
        const double inverse = 1 / norm(v);
        point.v[0] = v.x * inverse, point.v[1] = v.y * inverse, point.v[2] = v.z * inverse;
        point.pt = double(get_lane(f.start.y[6], i)), point.energy = double(get_lane(f.energy, i));
        job_.path_sink(job_.path_user, &point);
    }
}

}  // namespace kagero
