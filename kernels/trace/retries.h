/// Steps of the tracing loop that are taken again, with another length.
#pragma once

#include "kernels/trace/loop.h"

namespace kagero {

/// Lanes that go across the surface where H is not smooth, or across it and back, take their step again: to end on it, or where they start
/// on it, to where they would come out again if they went straight. A step that starts on it does not cross it there, and is
/// shortened at most once because it comes back.
///
/// The first try is by the parabola through the sides at the start and along its tangent, half the step and the whole step on: what grazes a
/// ball is inside for a length that goes with the root of its depth, and the end of a step may be that of stages on the wrong side. On, it
/// is by the secant through the last two tries.
template <class V>
std::uint64_t PacketTracer<V>::repeat_to_crease(std::uint64_t moving) {
    const V on(S(16) * machine_epsilon<S>), zero(S(0)), one(S(1)), &a = flow_.start.side, &end = flow_.end.side;
    const MaskOf<V> starts_on = abs(a) <= on, leaves = abs(end) > on;
    const std::uint64_t across = moving & to_bits((a * end < zero) & (abs(a) > on) & leaves);
    const std::uint64_t back = moving & ~across & to_bits(leaves);
    if (!(across | back)) return 0;
    const auto side_at = [&](const V& length) {
        State<V> there = flow_.start;
        there.set(advance(flow_.start.q(), length, flow_.start.velocity), flow_.start.p());
        return task_.kernel.side(task_.system, there);
    };
    const V middle = side_at(V(S(0.5)) * flow_.h), beyond = side_at(flow_.h), c = V(S(2)) * (a + beyond - V(S(2)) * middle), b = beyond - a - c;
    const V square = b * b - V(S(4)) * a * c, root = sqrt(max(square, zero)), sum = b + pick(b < zero, -root, root);
    const V first = V(S(-2)) * a / sum, least = pick(starts_on, V(std::sqrt(machine_epsilon<S>)), zero);
    const V share = pick((first > least) & (first < one), first, V(S(-0.5)) * sum / c);
    const MaskOf<V> found = (square > zero) & (share > least) & (share < one);
    const std::uint64_t leaping = back & not_yet_rejected(back) & to_bits(found & (pick(starts_on, -b, a) * beyond > zero));
    if (across) repeat(across, length_to_crease(across, pick(found, share, a / (a - end)) * flow_.h));
    if (leaping) repeat(leaping, share * flow_.h);
    return across | leaping;
}

/// A ray that grazes has its turning point between the last two tries: where their secant leads out of the step, the chord does not.
template <class V>
V PacketTracer<V>::length_to_crease(std::uint64_t lanes, const V& first) {
    const std::uint64_t fresh = not_yet_rejected(lanes);
    const V secant = flow_.h - flow_.end.side * (flow_.h - tried_h_) / (flow_.end.side - tried_side_);
    const V chord = flow_.h * flow_.start.side / (flow_.start.side - flow_.end.side);
    const V next = pick(from_bits<V>(fresh), first, pick((secant > V(S(0))) & (secant < flow_.h), secant, chord));
    const MaskOf<V> here = from_bits<V>(lanes);
    tried_h_ = pick(here, flow_.h, tried_h_), tried_side_ = pick(here, flow_.end.side, tried_side_);
    constexpr S shorter = S(0.98);  // than the last try, always: that ended across
    return min(next, V(shorter) * flow_.h);
}

/// Those of `lanes` whose step is the first of its start.
template <class V>
std::uint64_t PacketTracer<V>::not_yet_rejected(std::uint64_t lanes) const {
    std::uint64_t fresh = 0;
    for (const int i : lanes_in(lanes))
        if (rejections_[i] == 0) fresh |= std::uint64_t(1) << i;
    return fresh;
}

/// Steps that are not accepted are taken again with another length.
template <class V>
void PacketTracer<V>::repeat(std::uint64_t lanes, const V& length) {
    if (!lanes) return;
    repeated_ |= lanes;
    std::uint64_t failed = 0;
    for (const int i : lanes_in(lanes)) {
        if (++rejections_[i] >= max_rejections) failed |= std::uint64_t(1) << i;
    }
    restart(lanes, length);
    if (failed) fail(failed, failed, 0);
}

/// Lanes go back to the start of their step, without what the stepper remembers of it.
template <class V>
void PacketTracer<V>::restart(std::uint64_t lanes, const V& length) {
    const MaskOf<V> mask = from_bits<V>(lanes);
    flow_.h = pick(mask, length, flow_.h);
    if (task_.resumes) return;
    Flow<V> again = flow_;
    task_.begin(again);
    for (int k = 0; k < max_stages; ++k)
        for (int c = 0; c < 6; ++c) flow_.stage[k][c] = pick(mask, again.stage[k][c], flow_.stage[k][c]);
}

/// Lanes whose step has no solution, lost H or left the numbers go back and try half of it; the last halving fails the ray.
template <class V>
void PacketTracer<V>::retry(std::uint64_t bad, std::uint64_t unsolved, std::uint64_t lossy) {
    repeated_ |= bad;
    std::uint64_t failed = 0;
    for (const int i : lanes_in(bad)) {
        if (halvings_[i]++ >= max_halvings || all_halvings_[i]++ >= most_halvings) failed |= std::uint64_t(1) << i;
    }
    if (failed) bad &= ~end_at_edge(failed);
    restart(bad, flow_.h * V(S(0.5)));
    if (failed &= bad) fail(failed, unsolved, lossy);
}

/// Ends those of `lanes` whose steps, halved to nothing, lead along their tangent out of the medium or into what captures. Where H is no
/// number beyond the edge no step ends there; and they are on it, to what is left of a step.
template <class V>
std::uint64_t PacketTracer<V>::end_at_edge(std::uint64_t lanes) {
    if (!(task_.kernel.bounded || task_.kernel.capturing) || task_.method.info.angular) return 0;
    Flow<V> ahead = flow_;
    ahead.start.set(advance(flow_.start.q(), flow_.h, flow_.start.velocity), flow_.start.p());
    task_.begin(ahead);
    const std::uint64_t out = lanes & to_bits(ahead.start.domain <= V(S(0))), in = lanes & ~out & to_bits(ahead.start.captured <= V(S(0)));
    if (!(out | in)) return 0;
    Flow<V> last = flow_;
    last.end = last.start;
    retire(last, out, Status::escaped);
    retire(last, in, Status::captured);
    drop(out | in);
    return out | in;
}

/// Ends rays as `failed` where their last good step ended.
template <class V>
void PacketTracer<V>::fail(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t lossy) {
    Flow<V> last = flow_;
    last.end = last.start;
    retire(last, lanes & unsolved, Status::failed, Failure::not_converged);
    retire(last, lanes & lossy & ~unsolved, Status::failed, Failure::energy_lost);
    retire(last, lanes & ~(unsolved | lossy), Status::failed, Failure::not_finite);
    drop(lanes);
}

/// Lanes whose rays have ended where their step began.
template <class V>
void PacketTracer<V>::drop(std::uint64_t lanes) {
    const MaskOf<V> gone = from_bits<V>(lanes);
    flow_.h = pick(gone, V(S(0)), flow_.h);
    nominal_ = pick(gone, V(S(0)), nominal_);
    active_ &= ~lanes;
    make_harmless(lanes);
}

}  // namespace kagero
