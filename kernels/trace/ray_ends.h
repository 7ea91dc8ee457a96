/// The end of the tracing loop: lanes that wait to be delivered, and what is written of a ray when it ends and after each of its steps.
#pragma once

#include "kernels/trace/end_columns.h"
#include "kernels/trace/loop.h"

namespace kagero {

/// Hits become waiting lanes, except those that lie beyond the escape sphere.
template <class V>
std::uint64_t PacketTracer<V>::wait_for_surface(std::uint64_t hits) {
    if (!hits) return 0;
    const Encounter<V>& encounter = *encounter_;
    const Curve<V> curve = task_.curve(flow_);
    const V &from = encounter.from, &to = encounter.to, &t = encounter.t;
    const Vec3<V> a = curve.at(from), b = curve.at(to), hit = advance(a, t, b - a);
    const std::uint64_t accepted = hits & ~to_bits(is_beyond(hit));
    if (!accepted) return 0;
    const Level<V> levels = encounter.levels(accepted);
    landing_->wait(accepted, levels, from, to, mul_add(to - from, chord_fraction(levels, a, b, t), from));
    landing_->take(flow_, accepted);
    fell_on_surface_ |= accepted;
    for (const int i : lanes_in(accepted)) {
        KAGERO_ASSERT(encounter.surface[i] < job_.geometry->surface_count);
        surface_[i] = encounter.surface[i], primitive_[i] = encounter.primitive[i];
    }
    return accepted;
}

/// Whether places lie beyond the escape sphere, or beyond the other universe's.
template <class V>
MaskOf<V> PacketTracer<V>::is_beyond(const Vec3<V>& q) const {
    const V square = dot(q, q);
    return (square > V(S(job_.escape_radius) * S(job_.escape_radius))) | (square < V(S(job_.inner_escape_radius) * S(job_.inner_escape_radius)));
}

/// Those of `lanes`, which turn back inward during their step, that leave the escape sphere before; `exit` is where, and `farthest` where they
/// are farthest out, as fractions of the step.
template <class V>
std::uint64_t PacketTracer<V>::excursions(std::uint64_t lanes, V& exit, V& farthest) const {
    const V radius2(S(job_.escape_radius) * S(job_.escape_radius)), zero(S(0)), one(S(1)), half(S(0.5));
    const Vec3<V> a = flow_.start.q(), b = flow_.end.q();
    lanes &= to_bits((dot(a, a) < radius2) & (dot(b, b) < radius2));
    if (!lanes) return 0;
    const Curve<V> curve = task_.curve(flow_);
    lanes &= to_bits(curve.reach2() > radius2);
    if (!lanes) return 0;
    const auto bisect = [&](const V& until, const auto& is_before) {
        V before = zero, behind = until;
        for (int i = 0; i < 12; ++i) {
            const V middle = half * (before + behind);
            const MaskOf<V> still = is_before(middle);
            before = pick(still, middle, before), behind = pick(still, behind, middle);
        }
        return behind;
    };
    const auto square = [&](const V& s) { const Vec3<V> q = curve.at(s); return dot(q, q); };
    farthest = bisect(one, [&](const V& s) { return dot(curve.at(s), curve.slope(s)) > zero; });
    exit = bisect(farthest, [&](const V& s) { return square(s) < radius2; });
    return lanes & to_bits(square(farthest) > radius2);
}

/// Lanes whose step leads out of the escape sphere wait for it; those that come from beyond it and pass it by, for where they turn.
template <class V>
void PacketTracer<V>::leave_sphere(std::uint64_t lanes) {
    const V inner(S(job_.inner_escape_radius)), outer(S(job_.escape_radius));
    const Vec3<V> a = flow_.start.q(), b = flow_.end.q(), way = b - a;
    const V along = dot(a, way), nearest2 = dot(a, a) - along * along / dot(way, way);  // of the whole line
    const MaskOf<V> far_inside = (dot(a, a) < inner * inner) & (dot(b, b) < inner * inner);
    const std::uint64_t passing = lanes & to_bits(((dot(a, a) > outer * outer) & (nearest2 > outer * outer)) | far_inside);
    if (passing) wait_for_edge(passing, Edge::turn);
    const std::uint64_t waiting = lanes & ~passing;
    if (!waiting) return;
    wait_for_sphere(flow_.start, flow_.end, V(S(1)), waiting);
    landing_->take(flow_, waiting);
}

/// Lanes whose step from `from` leads out of the escape sphere, on either side: at the fraction `place` of it they are at `to`, beyond.
template <class V>
void PacketTracer<V>::wait_for_sphere(const Waypoint<V>& from, const Waypoint<V>& to, const V& place, std::uint64_t lanes) {
    const V inner(S(job_.inner_escape_radius)), outer(S(job_.escape_radius));
    const Vec3<V> a = from.q(), b = to.q();
    const Level<V> sphere = sphere_level<V>(pick(dot(b, b) <= inner * inner, inner, outer));
    landing_->wait(lanes, sphere, V(S(0)), place, place * chord_fraction(sphere, a, b, V(S(1))));
}

/// Lanes whose step ends beyond an edge of the medium, or captured, or past where they turn.
template <class V>
void PacketTracer<V>::wait_for_edge(std::uint64_t lanes, Edge edge) {
    landing_->wait_for_edge(flow_.start, flow_.end, V(S(1)), lanes, edge);
    landing_->take(flow_, lanes);
}

/// Whether rays that have landed on the escape sphere move inward there, or in the other universe outward: they have left it before.
template <class V>
std::uint64_t PacketTracer<V>::come_back(const Leg<V>& landed) const {
    const Vec3<V> q = landed.end.q();
    const V towards = dot(q, landed.end.velocity), other(S(job_.inner_escape_radius) * S(job_.escape_radius));
    return to_bits(pick(dot(q, q) < other, -towards, towards) < V(S(0)));
}

/// Lands who waits; of several edges and surfaces in one step on the first, found after as many landings.
template <class V>
void PacketTracer<V>::land() {
    constexpr int most_landings = 4;
    if (!landing_->waiting) return;
    const Stopwatch watch(job_.timed, counters_.landing_ticks);
    for (int i = 1; i <= most_landings && landing_->waiting; ++i) land_once(i < most_landings);
}

/// Lands who waits. With `more`, who lands beyond another edge has crossed that before, and waits again, to land there.
template <class V>
void PacketTracer<V>::land_once(bool more) {
    Landing<V>& landing = *landing_;
    landing.land(fell_on_surface_);
    landing.lost |= landing.on_sphere(fell_on_surface_) & come_back(landing.flow);
    std::uint64_t captured_before = 0, out_before = 0, away_before = 0;
    if (more) {
        captured_before = task_.kernel.capturing ? landing.landed_beyond(Edge::capture) : 0;
        out_before = task_.kernel.bounded ? landing.landed_beyond(Edge::domain) & ~captured_before : 0;
        away_before = landing.landed_beyond(S(job_.escape_radius)) & ~(captured_before | out_before);
    }
    const std::uint64_t elsewhere = captured_before | out_before | away_before;
    const std::uint64_t lost = landing.waiting & landing.lost, again = lost ? go_back(lost) : 0, ended = landing.waiting & ~(again | elsewhere);
    if (flow_.want_energy) worst_energy_ = pick(from_bits<V>(ended), max(worst_energy_, landing.flow.energy_error), worst_energy_);
    const std::uint64_t there = ended & ~lost, hits = there & fell_on_surface_, captured = there & landing.captured;
    retire(landing.flow, lost & ~again, Status::failed, Failure::not_landed);
    retire(landing.flow, hits, Status::hit);
    retire(landing.flow, captured, Status::captured);
    retire(landing.flow, there & ~(hits | captured), Status::escaped);
    for (const int i : lanes_in(ended)) tell_iterations(i, iterations_after_);
    for (const int i : lanes_in(there & landing.unrefined)) ends_[i]->unrefined = true, ++counters_.unrefined;
    fell_on_surface_ &= ~(again | elsewhere);
    landing.clear();
    if (!elsewhere) return;
    const Waypoint<V> beyond = landing.flow.end;
    const V place = landing.place();
    landing.take_again(elsewhere);
    if (captured_before) landing.wait_for_edge(landing.whole.start, beyond, place, captured_before, Edge::capture);
    if (out_before) landing.wait_for_edge(landing.whole.start, beyond, place, out_before, Edge::domain);
    if (away_before) wait_for_sphere(landing.whole.start, beyond, place, away_before);
}

/// Lanes whose step cannot be ended where it should be: it was too long. They take half of it from where it began; returned are those that
/// have not been halved too often.
template <class V>
std::uint64_t PacketTracer<V>::go_back(std::uint64_t lanes) {
    constexpr std::uint16_t worth = 16;  // halvings elsewhere cost a step, not a landing
    std::uint64_t again = 0;
    for (const int i : lanes_in(lanes)) {
        all_halvings_[i] = static_cast<std::uint16_t>(all_halvings_[i] + worth);
        if (halvings_[i]++ < max_halvings && all_halvings_[i] < most_halvings) again |= std::uint64_t(1) << i;
    }
    if (!again) return 0;
    const Leg<V>& whole = landing_->whole;
    const MaskOf<V> here = from_bits<V>(again);
    flow_.take(whole, here);
    nominal_ = pick(here, task_.method.info.adaptive ? whole.h : V(S(job_.step)), nominal_);
    steps_ = pick(here, steps_ - V(S(1)), steps_);
    flow_.open_iterations = pick(here, iterations_after_, flow_.open_iterations);
    note_direction(again);
    if (encounter_) encounter_->start_again(again & to_bits(steps_ <= V(S(0))));
    active_ |= again, repeated_ |= again;
    restart(again, whole.h * V(S(0.5)));
    return again;
}

/// Ends a ray that starts so far out that its numbers may not fit the packet's.
template <class V>
void PacketTracer<V>::retire_far_out(const RayStarts<W>& starts, int lane) {
    write_ends(flow_, std::uint64_t(1) << lane, Status::escaped, Failure::none);
    RayEnd& e = *ends_[lane];
    const auto y = [&](int k) { return starts.y[k][lane]; };
    const double inverse = 1 / norm(Vec3<double>{y(3), y(4), y(5)});
    for (int k = 0; k < 3; ++k) e.q[k] = y(k), e.p[k] = y(3 + k), e.v[k] = y(3 + k) * inverse;
    e.pt = y(6), e.parameter = e.energy_error = 0;
}

/// Ends the rays of `lanes` at the end of the step in `f`. Those that have left the numbers have none, but where they are captured all the same.
template <class V>
void PacketTracer<V>::retire(const Flow<V>& f, std::uint64_t lanes, Status status, Failure failure) {
    if (!lanes) return;
    const bool anywhere = status == Status::failed || status == Status::captured;
    const std::uint64_t finite = anywhere ? lanes : lanes & to_bits(is_finite(sum_of_all(f.end, f.end.velocity)));
    write_ends(f, finite, status, failure);
    write_ends(f, lanes & ~finite, Status::failed, Failure::not_finite);
}

template <class V>
void PacketTracer<V>::write_ends(const Flow<V>& f, std::uint64_t lanes, Status status, Failure failure) {
    if (!lanes) return;
    KAGERO_ASSERT((lanes & ~filled_) == 0);
    KAGERO_ASSERT((status == Status::failed) == (failure != Failure::none));
    const Vec3<V>& v = f.end.velocity;
    const V least(std::numeric_limits<S>::min()), largest = max(max(abs(v.x), abs(v.y)), max(abs(v.z), least));
    const Vec3<V> scaled = total_recip(largest) * v;  // by the angle of an orbit v is greater than its square may be
    const V inverse = rsqrt(dot(scaled, scaled));
    const Vec3<V> along = pick(is_finite(inverse), inverse, V(S(0))) * scaled;
    RayEnd same{};
    same.occupancy = occupancy_so_far(), same.status = status, same.failure = failure;
    EndColumns<V> ends(same);
    ends.set(offsetof(RayEnd, q), f.end.q()), ends.set(offsetof(RayEnd, p), f.end.p()), ends.set(offsetof(RayEnd, v), along);
    ends.set(offsetof(RayEnd, pt), f.start.y[6]), ends.set(offsetof(RayEnd, parameter), f.end.parameter);
    ends.set(offsetof(RayEnd, energy_error), worst_energy_);
    counters_.steps += ends.set_counts(offsetof(RayEnd, steps), steps_, lanes);
    counters_.gradients += ends.set_counts(offsetof(RayEnd, gradients), f.gradients, lanes);
    if (encounter_) counters_.queries += ends.set_counts(offsetof(RayEnd, queries), encounter_->queries(), lanes);
    if (status == Status::hit) ends.set_words(offsetof(RayEnd, surface), surface_), ends.set_words(offsetof(RayEnd, primitive), primitive_);
    ends.write(lanes, ends_);
    counters_.ended[static_cast<int>(status)] += static_cast<std::uint64_t>(__builtin_popcountll(lanes));
    if (flow_.issued_iterations > 0)
        for (const int i : lanes_in(lanes)) tell_iterations(i, flow_.open_iterations);
    // A failed ray ends where its last good step did, which has been reported.
    if (job_.path_sink && status != Status::failed) report_path(f, lanes & to_bits(steps_ > V(S(0))), false);
}

/// Counts what a ray needed; where it has waited, again, without what idle lanes count on to.
template <class V>
void PacketTracer<V>::tell_iterations(int lane, const V& now) {
    std::uint32_t& iterations = ends_[lane]->iterations;
    counters_.active_iterations -= iterations;
    iterations = static_cast<std::uint32_t>(get_lane(now, lane));
    counters_.active_iterations += iterations;
}

/// How full the packet was.
template <class V>
float PacketTracer<V>::occupancy_so_far() const {
    const std::uint64_t issued = counters_.issued_lane_steps - issued_before_;
    return issued > 0 ? float(double(counters_.active_lane_steps - active_before_) / double(issued)) : 0;
}

/// Tells it to the rays of lanes: their packet has gone on without them.
template <class V>
void PacketTracer<V>::tell_occupancy(std::uint64_t lanes) {
    const float occupancy = occupancy_so_far();
    for (const int i : lanes_in(lanes)) ends_[i]->occupancy = occupancy;
}

template <class V>
void PacketTracer<V>::report_path(const Flow<V>& f, std::uint64_t lanes, bool at_start) {
    const State<V>& state = at_start ? f.start : f.end;
    const Vec3<V>& velocity = at_start ? f.start.velocity : f.end.velocity;
    for (const int i : lanes_in(lanes)) {
        PathPoint point{};
        point.ray = numbers_[i], point.step = at_start ? 0 : static_cast<std::uint32_t>(get_lane(steps_, i));
        point.parameter = double(get_lane(at_start ? f.start.parameter : f.end.parameter, i));
        for (int k = 0; k < 3; ++k) point.q[k] = double(get_lane(state.y[k], i)), point.p[k] = double(get_lane(state.y[3 + k], i));
        const Vec3<double> v = lane_of(velocity, i);
        const double inverse = 1 / norm(v);
        point.v[0] = v.x * inverse, point.v[1] = v.y * inverse, point.v[2] = v.z * inverse;
        point.pt = double(get_lane(f.start.y[6], i)), point.energy = double(get_lane(f.energy, i));
        job_.path_sink(job_.path_user, &point);
    }
}

}  // namespace kagero
