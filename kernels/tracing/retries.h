/// Steps of the tracing loop that are taken again, with another length.
#pragma once

#include "kernels/tracing/loop.h"

namespace kagero {

/// Lanes that go across the surface where H is not smooth take their step again, to end on it.
template <class V>
std::uint64_t PacketTracer<V>::repeat_to_crease(std::uint64_t moving) {
    const std::uint64_t across = crosses_crease(moving);
    if (across) repeat(across, length_to_crease(across));
    V length;
    const std::uint64_t leaping = leaps_crease(moving & ~across, length);
    if (leaping) repeat(leaping, length);
    return across | leaping;
}

/// Lanes that have stepped across the surface. A step that starts on it has not crossed it.
template <class V>
std::uint64_t PacketTracer<V>::crosses_crease(std::uint64_t moving) const {
    const V on(S(16) * machine_epsilon<S>);
    return moving & to_bits((flow_.start_side * flow_.side < V(S(0))) & (abs(flow_.start_side) > on) & (abs(flow_.side) > on));
}

/// Lanes that have stepped across it and back, and how long a step is that does not: to where the ray first meets the surface, or of one
/// that starts there, to where it would come out again if it went straight. By the parabola through the sides of the start, the middle
/// and the end of the chord.
template <class V>
std::uint64_t PacketTracer<V>::leaps_crease(std::uint64_t moving, V& length) const {
    const V on(S(16) * machine_epsilon<S>), zero(S(0)), &a = flow_.start_side, &end = flow_.side;
    const MaskOf<V> starts_on = abs(a) <= on;
    const std::uint64_t back = moving & to_bits((abs(end) > on) & (starts_on | (a * end > zero)));
    if (!back) return 0;
    State<V> middle;
    for (int k = 0; k < 7; ++k) middle.y[k] = V(S(0.5)) * (flow_.start.y[k] + flow_.end.y[k]);
    const V c = V(S(2)) * (a + end - V(S(2)) * task_.kernel.side(task_.system, middle)), b = end - a - c;
    const V square = b * b - V(S(4)) * a * c, root = sqrt(max(square, zero));
    const V first = V(S(-2)) * a / (b + pick(b < zero, -root, root));
    const V share = pick(starts_on, -b / c, first), least = pick(starts_on, V(std::sqrt(machine_epsilon<S>)), zero);
    length = share * flow_.h;
    return back & to_bits((square > zero) & (share > least) & (share < V(S(1))) & ((abs(a) > on) | (b * end < zero)));
}

/// The step that ends on the crease, by the secant through the last two tries, of which the first is the start. A ray that grazes has
/// its turning point between them: where their secant leads out of the step, that through the start and the end of the step does not.
template <class V>
V PacketTracer<V>::length_to_crease(std::uint64_t lanes) {
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (rejections_[i] == 0) set_lane(tried_h_, i, S(0)), set_lane(tried_side_, i, get_lane(flow_.start_side, i));
    }
    const V secant = flow_.h - flow_.side * (flow_.h - tried_h_) / (flow_.side - tried_side_);
    const V chord = flow_.h * flow_.start_side / (flow_.start_side - flow_.side);
    const V next = pick((secant > V(S(0))) & (secant < flow_.h), secant, chord);
    const MaskOf<V> here = from_bits<V>(lanes);
    tried_h_ = pick(here, flow_.h, tried_h_), tried_side_ = pick(here, flow_.side, tried_side_);
    return min(next, V(S(0.98)) * flow_.h);
}

/// Steps that are not accepted are taken again with another length.
template <class V>
void PacketTracer<V>::repeat(std::uint64_t lanes, const V& length) {
    if (!lanes) return;
    repeated_ |= lanes;
    std::uint64_t failed = 0;
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (++rejections_[i] >= max_rejections) failed |= std::uint64_t(1) << i;
    }
    restart(lanes, length);
    if (failed) fail(failed, failed, 0);
}

/// Lanes go back to the start of their step, without what the stepper remembers of it.
template <class V>
void PacketTracer<V>::restart(std::uint64_t lanes, const V& length) {
    Flow<V> again = flow_;
    task_.begin(again);
    const MaskOf<V> mask = from_bits<V>(lanes);
    for (int k = 0; k < max_stages; ++k)
        for (int c = 0; c < 6; ++c) flow_.stage[k][c] = pick(mask, again.stage[k][c], flow_.stage[k][c]);
    flow_.h = pick(mask, length, flow_.h);
}

/// Lanes whose step has no solution, lost H or left the numbers go back and try half of it; the last halving fails the ray.
template <class V>
void PacketTracer<V>::retry(std::uint64_t bad, std::uint64_t unsolved, std::uint64_t lossy) {
    repeated_ |= bad;
    std::uint64_t failed = 0;
    for (std::uint64_t rest = bad; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (halvings_[i]++ >= max_halvings || all_halvings_[i]++ >= most_halvings) failed |= std::uint64_t(1) << i;
    }
    restart(bad, flow_.h * V(S(0.5)));
    if (failed) fail(failed, unsolved, lossy);
}

/// Ends rays as `failed` where their last good step ended.
template <class V>
void PacketTracer<V>::fail(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t lossy) {
    Flow<V> last = flow_;
    last.end = last.start, last.end_velocity = last.start_velocity, last.end_parameter = last.start_parameter;
    retire(last, lanes & unsolved, Status::failed, Failure::not_converged);
    retire(last, lanes & lossy & ~unsolved, Status::failed, Failure::energy_lost);
    retire(last, lanes & ~(unsolved | lossy), Status::failed, Failure::not_finite);
    const MaskOf<V> gone = from_bits<V>(lanes);
    flow_.h = pick(gone, V(S(0)), flow_.h);
    nominal_ = pick(gone, V(S(0)), nominal_);
    active_ &= ~lanes;
    make_harmless(lanes);
}

}  // namespace kagero
