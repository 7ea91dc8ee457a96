/// The beginning of the tracing loop: rays into lanes, at first and where lanes have fallen free.
#pragma once

#include "kernels/trace/loop.h"

namespace kagero {

/// A packet's first rays; false where there are none. Lanes without one follow another.
template <class V>
bool PacketTracer<V>::fill(RayQueue<W>& queue) {
    RayStarts<W> starts;
    const std::uint64_t lanes = queue.take(all_lanes<W>, starts, ends_, numbers_);
    if (!lanes) return false;
    flow_.want_energy = !task_.straight && (job_.outputs & output_energy) != 0;
    flow_.want_path = job_.path_sink;
    flow_.test_energy = !task_.straight;
    flow_.use_symmetry = job_.use_symmetry;
    flow_.capture_within = S(job_.capture_within), flow_.capture_stretch = S(job_.capture_stretch);
    flow_.want_carried =
        (job_.outputs & output_parameter) != 0 || job_.path_sink || std::isfinite(job_.parameter_limit);
    flow_.solver_tolerance = S(job_.solver_tolerance);
    flow_.tolerance = S(job_.tolerance);
    filled_ = lanes;
    flow_.open_iterations = iterations_after_ = steps_ = nominal_ = flow_.h = V(S(0));
    tried_h_ = tried_side_ = V(S(0));
    put(starts, lanes, flow_);
    task_.begin(flow_);
    worst_energy_ = flow_.energy_error;
    enter(starts, lanes);
    return true;
}

/// Rays into lanes whose own have ended.
template <class V>
void PacketTracer<V>::refill(RayQueue<W>& queue) {
    land();
    tell_occupancy(~active_ & filled_);
    RayStarts<W> starts;
    const std::uint64_t lanes = queue.take(~active_ & all_lanes<W>, starts, ends_, numbers_);
    if (!lanes) return;
    if (encounter_) encounter_->begin(lanes);
    Flow<V> fresh = flow_;
    put(starts, lanes, fresh);
    task_.begin(fresh);
    const MaskOf<V> here = from_bits<V>(lanes);
    flow_.take(fresh, here);
    for (int i = 0; i < max_stages; ++i)
        for (int k = 0; k < 6; ++k) flow_.stage[i][k] = pick(here, fresh.stage[i][k], flow_.stage[i][k]);
    filled_ |= lanes;
    steps_ = pick(here, V(S(0)), steps_);
    flow_.open_iterations = pick(here, V(S(0)), flow_.open_iterations);
    worst_energy_ = pick(here, flow_.energy_error, worst_energy_);
    repeated_ &= ~lanes, fell_on_surface_ &= ~lanes;
    for (const int i : lanes_in(lanes)) {
        halvings_[i] = rejections_[i] = 0, all_halvings_[i] = 0;
    }
    enter(starts, lanes);
}

/// Puts the start of rays into a flow; lanes that are not of `lanes` follow one that is.
template <class V>
void PacketTracer<V>::put(RayStarts<W>& starts, std::uint64_t lanes, Flow<V>& flow) const {
    const V zero(S(0));
    starts.fill_up(lanes);
    for (V& c : flow.start.carry) c = zero;
    // Only the plane of an orbit is told apart by more digits than the packet has.
    for (int k = 0; k < 7; ++k) {
        if (k < 6 && task_.method.info.angular) flow.start.y[k] = lanes_of<V>(starts.y[k], flow.start.carry[k]);
        else flow.start.y[k] = lanes_of<V>(starts.y[k]);
    }
    flow.start.parameter = flow.end.parameter = flow.gradients = flow.energy_error = flow.energy = zero;
}

/// New rays of `lanes` become active, except those that end where they start: unusable and captured ones, and those that start outside
/// the medium, or beyond the escape sphere moving outward.
template <class V>
void PacketTracer<V>::enter(const RayStarts<W>& starts, std::uint64_t lanes) {
    std::uint64_t usable = lanes & to_bits(is_finite(sum_of_all(flow_.start, flow_.start.velocity)));
    usable &= ~(starts.captured | starts.escaped | starts.failed);
    const std::uint64_t away =
        usable & to_bits(leaves_space(flow_.start.q(), flow_.start.velocity) | (flow_.start.domain <= V(S(0))));
    const std::uint64_t captured = usable & ~away & to_bits(flow_.start.captured <= V(S(0)));
    const std::uint64_t entered = usable & ~(away | captured);
    if (job_.path_sink) report_path(flow_, usable, true);
    if (lanes != entered) flow_.end = flow_.start;  // whose rays end at once end there
    for (const int i : lanes_in(lanes & ~usable)) {
        const std::uint64_t lane = std::uint64_t(1) << i;
        if (starts.captured & lane) retire(flow_, lane, Status::captured);
        else if (starts.escaped & lane) retire_far_out(starts, i);
        else {
            retire(flow_, lane, Status::failed, starts.failed & lane ? starts.failure[i] : Failure::singular_start);
            ends_[i]->energy_error = std::numeric_limits<double>::quiet_NaN();  // of no ray
        }
    }
    retire(flow_, away, Status::escaped);
    retire(flow_, captured, Status::captured);
    active_ |= entered;
    make_harmless(all_lanes<W> & ~active_ & ~usable);
    if (!task_.in_closed_form()) set_out(lanes);
}

/// New rays in `lanes`: their first steps.
template <class V>
void PacketTracer<V>::set_out(std::uint64_t lanes) {
    const MaskOf<V> here = from_bits<V>(lanes);
    nominal_ = pick(here, pick(from_bits<V>(active_), V(S(job_.step)), V(S(0))), nominal_);
    flow_.h = pick(here, step_length(), flow_.h);
    note_direction(lanes);
}

/// Lanes without a usable state follow a neighbour that has one, with steps of length zero.
template <class V>
void PacketTracer<V>::make_harmless(std::uint64_t lanes) {
    if (!active_ || !lanes) return;
    const int donor = __builtin_ctzll(active_);
    for (int i = 0; i < W; ++i) {
        if (!((lanes >> i) & 1)) continue;
        const auto copy = [&](V& v, const V& from) { set_lane(v, i, get_lane(from, donor)); };
        Waypoint<V>::each(flow_.start, flow_.start, copy);
        for (auto& stage : flow_.stage)
            for (V& g : stage) copy(g, g);
    }
}

/// How long straight rays take to the escape sphere, and a little more: twice the distance where a ray still comes in from outside. Every
/// straight ray ends within two such steps.
template <class V>
KAGERO_INLINE V PacketTracer<V>::straight_way_out() const {
    const Vec3<V> q = flow_.start.q(), v = flow_.start.velocity;
    const V inverse = recip(dot(v, v)), along = dot(q, v) * inverse, radius = V(S(job_.escape_radius));
    const V way = root(max(mul_add(along, along, inverse * (radius * radius - dot(q, q))), V(S(0)))) - along;
    return max(way, root(dot(q, q) * inverse) * V(S(1e-3))) * V(S(1.001));
}

/// How long rays go straight until they come to the sphere Job::bends_within; 0 inside, and very long where they pass it by. What misses it is
/// told by |q × v|, which floats know better than the difference of two squares.
template <class V>
V PacketTracer<V>::straight_way_in() const {
    const Vec3<V> q = flow_.start.q(), v = flow_.start.velocity, moment = cross(q, v);
    const V zero(S(0)), square = V(S(job_.bends_within) * S(job_.bends_within)), height = dot(q, q) - square, inward = -dot(q, v);
    const V depth = square * dot(v, v) - dot(moment, moment);
    const MaskOf<V> meets = (inward > zero) & (depth > zero);
    return pick(height > zero, pick(meets, height / (inward + root(max(depth, zero))), V(std::numeric_limits<S>::max())), zero);
}

/// Job::longest_share of |q|, and a ten-thousandth of the escape radius, so that a ray gets past the origin.
template <class V>
V PacketTracer<V>::longest_leap() const {
    const Vec3<V> q = flow_.start.q();
    return mul_add(V(S(job_.longest_share)), sqrt(dot(q, q)), V(S(1e-4 * job_.escape_radius)));
}

/// Step length of each lane: the job's, or for rays that are straight, or go straight first, the way to the escape sphere and a little more,
/// or as far as they do, or what is left of λ.
template <class V>
V PacketTracer<V>::bounded_step_length() const {
    V h = nominal_;
    if (task_.straight) h = pick(nominal_ > V(S(0)), straight_way_out(), V(S(0)));
    if (task_.kernel.scaled && !task_.straight) {
        V scale = flow_.start.scale;
        if (std::isfinite(job_.longest_share) && task_.method.info.adaptive) scale = min(scale, longest_leap());
        const V square = dot(flow_.start.velocity, flow_.start.velocity);
        const MaskOf<V> longer = h * h * square > scale * scale;
        if (any(longer)) h = pick(longer, scale / sqrt(square), h);
    }
    if (std::isfinite(job_.bends_within) && !task_.straight) h = pick(nominal_ > V(S(0)), max(h, min(straight_way_in(), straight_way_out())), h);
    if (std::isfinite(job_.parameter_limit)) {
        // The last step ends at the limit, without a sliver of another one behind it.
        const V left = V(S(job_.parameter_limit)) - flow_.start.parameter;
        h = pick(left <= h * V(S(1 + 1e-6)), pick(h > V(S(0)), left, h), h);
    }
    return h;
}

}  // namespace kagero
