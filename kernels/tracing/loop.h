/// The tracing loop: rays in lockstep, each lane leaving when its own ray ends.
///
/// Compiled once per value type; scalar, and packets of any width, run these lines. The Hamiltonian and the method are behind
/// `SpaceKernel`. A finished lane keeps a harmless state and a step of length zero, so steppers need no masks.
#pragma once

#include "kernels/tracing/encounter.h"
#include "kernels/tracing/landing.h"
#include "kernels/tracing/ray_source.h"
#include "kernels/tracing/task.h"

namespace kagero {

/// Finite exactly where state and velocity are (short of sums that overflow, which nothing survives either).
template <class V>
V sum_of_sizes(const State<V>& s, const Vec3<V>& v) {
    V size = abs(v.x) + abs(v.y) + abs(v.z);
    for (int k = 0; k < 6; ++k) size = size + abs(s.y[k]);
    return size;
}

/// One packet of rays from start to end.
template <class V>
class PacketTracer {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    PacketTracer(const Task<V>& task, Counters& counters) : task_(task), job_(task.job), counters_(counters) {}

    /// Traces starts[i] for the lanes of `lanes` into *ends[i]; `first_ray` numbers the rays for the path sink.
    void trace(const RayStart (&starts)[W], std::uint64_t lanes, RayEnd* const (&ends)[W], const std::uint64_t (&numbers)[W]) {
        ends_ = ends, numbers_ = numbers;
        fill(starts, lanes);
        Landing<V> landing;
        if (job_.geometry) {
            Encounter<V> encounter(job_);
            encounter.begin(active_);
            while (active_) advance_once(landing, &encounter);
            counters_.queries += encounter.queries, counters_.query_ticks += encounter.ticks;
        } else {
            while (active_) advance_once(landing, nullptr);
        }
        land(landing);
        counters_.issued_iterations += flow_.issued_iterations * W;
        for (int i = 0; i < W; ++i) counters_.active_iterations += static_cast<std::uint64_t>(get_lane(flow_.open_iterations, i));
    }

private:
    void fill(const RayStart (&starts)[W], std::uint64_t lanes);
    void retire_at_start(const RayStart (&starts)[W], std::uint64_t lanes);
    void advance_once(Landing<V>& landing, Encounter<V>* encounter);
    std::uint64_t leave(Landing<V>& landing, Encounter<V>* encounter, std::uint64_t moving);
    std::uint64_t crosses_crease(std::uint64_t moving) const;
    V length_to_crease(std::uint64_t lanes);
    void retry(std::uint64_t bad, std::uint64_t unsolved, std::uint64_t lossy);
    void repeat(std::uint64_t lanes, const V& length);
    void restart(std::uint64_t lanes, const V& length);
    MaskOf<V> leaves_space(const Vec3<V>& q, const Vec3<V>& v) const;
    void fail(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t lossy);
    void retire_far_out(const RayStart& start, int lane);
    void make_harmless(std::uint64_t lanes);
    void commit(std::uint64_t lanes, std::uint64_t staying);
    std::uint64_t wait_for_surface(Landing<V>& landing, const Encounter<V>& encounter, std::uint64_t hits);
    void wait_for_sphere(Landing<V>& landing, std::uint64_t lanes);
    void land(Landing<V>& landing);
    void retire(const Flow<V>& f, int lane, Status status, Failure failure);
    void report_path(const Flow<V>& f, std::uint64_t lanes, bool at_start);
    V step_length() const;

    const Task<V>& task_;
    const Job& job_;
    Counters& counters_;
    Flow<V> flow_;
    V nominal_;                     ///< step length of active lanes, 0 in finished ones
    V worst_energy_;
    V tried_h_, tried_side_;        ///< of lanes that search for the crease: their last try
    std::uint64_t active_ = 0;
    std::uint64_t repeated_ = 0;    ///< lanes that had to take their step again
    V steps_;                       ///< whole numbers, exactly
    std::uint8_t halvings_[W] = {};
    std::uint16_t all_halvings_[W] = {};
    std::uint8_t rejections_[W] = {};
    std::uint32_t surface_[W], primitive_[W];
    std::uint64_t fell_on_surface_ = 0;
    RayEnd* const* ends_ = nullptr;
    const std::uint64_t* numbers_ = nullptr;

    /// How often a step without solution is halved before its ray fails.
    static constexpr int max_halvings = 24;
    /// The same for all steps of a ray: one that creeps on by halvings alone would hardly ever end.
    static constexpr int most_halvings = 4000;
    /// How often in a row a step is taken again with another length before its ray fails.
    static constexpr int max_rejections = 60;
};

template <class V>
void PacketTracer<V>::fill(const RayStart (&starts)[W], std::uint64_t lanes) {
    for (int i = 0; i < W; ++i) {
        const bool given = (lanes >> i) & 1;
        if (given && starts[i].failure == Failure::none && !starts[i].captured && !starts[i].escaped) active_ |= std::uint64_t(1) << i;
        const RayStart& r = starts[given ? i : __builtin_ctzll(lanes)];
        for (int k = 0; k < 3; ++k) set_lane(flow_.start.y[k], i, S(r.q[k])), set_lane(flow_.start.y[3 + k], i, S(r.p[k]));
        set_lane(flow_.start.y[6], i, S(r.pt));
    }
    flow_.want_energy = !task_.straight && (job_.outputs & output_energy) != 0;
    flow_.want_path = job_.path_sink;
    flow_.test_energy = !task_.straight;
    flow_.want_parameter = (job_.outputs & output_parameter) != 0 || job_.path_sink || std::isfinite(job_.parameter_limit);
    flow_.solver_tolerance = S(job_.solver_tolerance);
    flow_.tolerance = S(job_.tolerance);
    flow_.start_parameter = flow_.end_parameter = V(S(0));
    flow_.gradients = flow_.open_iterations = steps_ = V(S(0));
    flow_.energy_error = flow_.energy = V(S(0));
    tried_h_ = tried_side_ = V(S(0));
    task_.begin(flow_);
    worst_energy_ = flow_.energy_error;
    flow_.end = flow_.start, flow_.end_velocity = flow_.start_velocity;
    retire_at_start(starts, lanes);
    nominal_ = pick(from_bits<V>(active_), V(S(job_.step)), V(S(0)));
    flow_.h = step_length();
    report_path(flow_, active_, true);
}

/// Whether rays at q that move along v are beyond the escape sphere, moving outward; in a wormhole's other universe outward is inward.
template <class V>
MaskOf<V> PacketTracer<V>::leaves_space(const Vec3<V>& q, const Vec3<V>& v) const {
    const V outward = dot(q, v), square = dot(q, q);
    const MaskOf<V> here = (square >= V(S(job_.escape_radius) * S(job_.escape_radius))) & (outward > V(S(0)));
    if (!(job_.inner_escape_radius > 0)) return here;
    return here | ((square <= V(S(job_.inner_escape_radius) * S(job_.inner_escape_radius))) & (outward < V(S(0))));
}

/// Rays that end where they start: unusable and captured ones, and those that start outside the medium, or beyond the escape sphere
/// moving outward.
template <class V>
void PacketTracer<V>::retire_at_start(const RayStart (&starts)[W], std::uint64_t lanes) {
    const std::uint64_t usable = active_ & to_bits(is_finite(sum_of_sizes(flow_.start, flow_.start_velocity)));
    const std::uint64_t away =
        usable & to_bits(leaves_space(flow_.start.q(), flow_.start_velocity) | (flow_.start_domain <= V(S(0))));
    const std::uint64_t captured = usable & ~away & to_bits(flow_.captured <= V(S(0)));
    report_path(flow_, away | captured, true);
    for (std::uint64_t rest = lanes & ~usable; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const Failure failure = starts[i].failure;
        if (starts[i].captured) retire(flow_, i, Status::captured, Failure::none);
        else if (starts[i].escaped) retire_far_out(starts[i], i);
        else retire(flow_, i, Status::failed, failure == Failure::none ? Failure::singular_start : failure);
    }
    for (std::uint64_t rest = away; rest; rest &= rest - 1) retire(flow_, __builtin_ctzll(rest), Status::escaped, Failure::none);
    for (std::uint64_t rest = captured; rest; rest &= rest - 1) retire(flow_, __builtin_ctzll(rest), Status::captured, Failure::none);
    active_ = usable & ~away & ~captured;
    make_harmless(~usable);
}

/// Lanes without a usable state follow a neighbour that has one, with steps of length zero.
template <class V>
void PacketTracer<V>::make_harmless(std::uint64_t lanes) {
    if (!active_) return;
    const int donor = __builtin_ctzll(active_);
    for (int i = 0; i < W; ++i) {
        if (!((lanes >> i) & 1)) continue;
        const auto copy = [&](V& v) { set_lane(v, i, get_lane(v, donor)); };
        for (V& y : flow_.start.y) copy(y);
        for (V& c : flow_.carry) copy(c);
        copy(flow_.start_velocity.x), copy(flow_.start_velocity.y), copy(flow_.start_velocity.z), copy(flow_.start_domain), copy(flow_.start_side);
        copy(flow_.start_scale), copy(flow_.start_energy_terms);
        for (auto& stage : flow_.stage)
            for (V& g : stage) copy(g);
    }
}

/// Step length of each lane: the job's, or for straight rays the way to the escape sphere and a little more, or what is left of λ.
template <class V>
V PacketTracer<V>::step_length() const {
    V h = nominal_;
    if (task_.straight) {
        const Vec3<V> q = flow_.start.q(), v = flow_.start_velocity;
        const V vv = dot(v, v), along = dot(q, v), radius = V(S(job_.escape_radius));
        // Twice the distance where a ray still comes in from outside; every straight ray ends within two such steps.
        const V way = (sqrt(max(mul_add(along, along, vv * (radius * radius - dot(q, q))), V(S(0)))) - along) / vv;
        h = pick(nominal_ > V(S(0)), max(way, sqrt(dot(q, q) / vv) * V(S(1e-3))) * V(S(1.001)), V(S(0)));
    }
    if (task_.kernel.scaled && !task_.straight) {
        const V speed = sqrt(dot(flow_.start_velocity, flow_.start_velocity));
        h = pick(h * speed > flow_.start_scale, flow_.start_scale / speed, h);
    }
    if (std::isfinite(job_.parameter_limit)) {
        // The last step ends at the limit, without a sliver of another one behind it.
        const V left = V(S(job_.parameter_limit)) - flow_.start_parameter;
        h = pick(left <= h * V(S(1 + 1e-6)), pick(h > V(S(0)), left, h), h);
    }
    return h;
}

template <class V>
void PacketTracer<V>::advance_once(Landing<V>& landing, Encounter<V>* encounter) {
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(active_));
    task_.step(flow_);
    const std::uint64_t finite = to_bits(is_finite(sum_of_sizes(flow_.end, flow_.end_velocity))), solved = to_bits(flow_.solved);
    const bool adaptive = task_.method.info.adaptive && !task_.straight;
    const std::uint64_t accepted = adaptive ? to_bits(flow_.accepted) : active_;
    // Beyond the medium's edge H means nothing.
    const std::uint64_t lossy = flow_.test_energy ? accepted & ~to_bits(flow_.energy_holds | (flow_.domain <= V(S(0)))) : 0;
    std::uint64_t moving = active_ & finite & solved & ~lossy;
    if (moving != active_) retry(active_ & ~moving, active_ & ~solved, lossy & finite & solved);
    if (adaptive) {
        repeat(moving & ~accepted, flow_.suggested);
        moving &= accepted;
        nominal_ = pick(from_bits<V>(moving), flow_.suggested, nominal_);
    }
    if (const std::uint64_t across = task_.kernel.creased ? crosses_crease(moving) : 0) {
        repeat(across, length_to_crease(across));
        moving &= ~across;
    }
    const MaskOf<V> moved = from_bits<V>(moving);
    steps_ = pick(moved, steps_ + V(S(1)), steps_);
    if (flow_.want_energy) worst_energy_ = pick(moved, max(worst_energy_, flow_.energy_error), worst_energy_);
    const std::uint64_t staying = moving & ~leave(landing, encounter, moving);
    report_path(flow_, staying, false);
    commit(moving, staying);
}

/// The lanes of `moving` whose rays end with this step: they wait for landing, or are retired at once.
template <class V>
std::uint64_t PacketTracer<V>::leave(Landing<V>& landing, Encounter<V>* encounter, std::uint64_t moving) {
    std::uint64_t staying = moving;
    if (encounter) staying &= ~wait_for_surface(landing, *encounter, encounter->meet(flow_, moving));
    const std::uint64_t beyond = task_.kernel.bounded ? staying & to_bits(flow_.domain <= V(S(0))) : 0;
    for (std::uint64_t rest = beyond; rest; rest &= rest - 1) landing.wait_for_edge(flow_, __builtin_ctzll(rest));
    staying &= ~beyond;
    const std::uint64_t outside = staying & to_bits(leaves_space(flow_.end.q(), flow_.end_velocity));
    if (outside) wait_for_sphere(landing, outside);
    staying &= ~outside;
    const std::uint64_t captured = task_.kernel.capturing ? staying & to_bits(flow_.captured <= V(S(0))) : 0;
    for (std::uint64_t rest = captured; rest; rest &= rest - 1) retire(flow_, __builtin_ctzll(rest), Status::captured, Failure::none);
    staying &= ~captured;
    std::uint64_t limited = 0;
    if (std::isfinite(job_.parameter_limit)) {
        const S limit = S(job_.parameter_limit);
        limited = staying & to_bits(flow_.end_parameter >= V(limit * (1 - 4 * machine_epsilon<S>)));
        flow_.end_parameter = pick(from_bits<V>(limited), V(limit), flow_.end_parameter);
    }
    limited |= staying & to_bits(steps_ >= V(S(job_.max_steps)));
    for (std::uint64_t rest = limited; rest; rest &= rest - 1) retire(flow_, __builtin_ctzll(rest), Status::step_limit, Failure::none);
    return moving & ~(staying & ~limited);
}

/// Lanes that have stepped across the surface where H is not smooth: they are to end on it. A step that starts on it has not crossed it.
template <class V>
std::uint64_t PacketTracer<V>::crosses_crease(std::uint64_t moving) const {
    const V on(S(16) * machine_epsilon<S>);
    return moving & to_bits((flow_.start_side * flow_.side < V(S(0))) & (abs(flow_.start_side) > on) & (abs(flow_.side) > on));
}

/// The step that ends on the crease, by the secant through the last two tries, of which the first is the start.
template <class V>
V PacketTracer<V>::length_to_crease(std::uint64_t lanes) {
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (rejections_[i] == 0) set_lane(tried_h_, i, S(0)), set_lane(tried_side_, i, get_lane(flow_.start_side, i));
    }
    const V next = flow_.h - flow_.side * (flow_.h - tried_h_) / (flow_.side - tried_side_);
    const MaskOf<V> here = from_bits<V>(lanes);
    tried_h_ = pick(here, flow_.h, tried_h_), tried_side_ = pick(here, flow_.side, tried_side_);
    return max(min(next, V(S(0.98)) * flow_.h), V(S(0)));
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
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const auto in = [i](std::uint64_t set) { return (set >> i) & 1; };
        retire(last, i, Status::failed, in(unsolved) ? Failure::not_converged : in(lossy) ? Failure::energy_lost : Failure::not_finite);
    }
    const MaskOf<V> gone = from_bits<V>(lanes);
    flow_.h = pick(gone, V(S(0)), flow_.h);
    nominal_ = pick(gone, V(S(0)), nominal_);
    active_ &= ~lanes;
    make_harmless(lanes);
}

/// The step of `lanes` becomes the start of the next for those that stay.
template <class V>
void PacketTracer<V>::commit(std::uint64_t lanes, std::uint64_t staying) {
    if (const std::uint64_t leaving = lanes & ~staying) {
        active_ &= ~leaving;
        nominal_ = pick(from_bits<V>(leaving), V(S(0)), nominal_);
    }
    const MaskOf<V> go = from_bits<V>(staying), done = from_bits<V>(~active_);
    for (int k = 0; k < 6; ++k) flow_.start.y[k] = pick(go, flow_.end.y[k], flow_.start.y[k]);
    for (int k = 0; k < 6; ++k) flow_.carry[k] = pick(go, flow_.next_carry[k], flow_.carry[k]);
    flow_.start_velocity = pick<V>(go, flow_.end_velocity, flow_.start_velocity);
    flow_.start_parameter = pick(go, flow_.end_parameter, flow_.start_parameter);
    flow_.start_domain = pick(go, flow_.domain, flow_.start_domain);
    flow_.start_energy_terms = pick(go, flow_.energy_terms, flow_.start_energy_terms);
    if (task_.kernel.scaled) flow_.start_scale = pick(go, flow_.scale, flow_.start_scale);
    if (task_.kernel.creased) flow_.start_side = pick(go, flow_.side, flow_.start_side);
    flow_.h = pick(go | done, step_length(), flow_.h);
    for (std::uint64_t rest = staying & repeated_; rest; rest &= rest - 1)
        halvings_[__builtin_ctzll(rest)] = rejections_[__builtin_ctzll(rest)] = 0;
    repeated_ &= ~staying;
}

/// Hits become waiting lanes, except those that lie beyond the escape sphere.
template <class V>
std::uint64_t PacketTracer<V>::wait_for_surface(Landing<V>& landing, const Encounter<V>& encounter, std::uint64_t hits) {
    if (!hits) return 0;
    const Curve<V> curve = Curve<V>::of_step(flow_);
    const auto lane_of = [](const Vec3<V>& v, int i) {
        return Vec3<double>{double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
    };
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
        landing.wait(flow_, i, level, lo, hi, lo + (hi - lo) * chord_fraction(level, a1, b1, encounter.t[i]));
        surface_[i] = encounter.surface[i], primitive_[i] = encounter.primitive[i];
        accepted |= std::uint64_t(1) << i;
    }
    fell_on_surface_ |= accepted;
    return accepted;
}

template <class V>
void PacketTracer<V>::wait_for_sphere(Landing<V>& landing, std::uint64_t lanes) {
    const Vec3<V> a = flow_.start.q(), b = flow_.end.q();
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        const auto lane_of = [i](const Vec3<V>& v) {
            return Vec3<double>{double(get_lane(v.x, i)), double(get_lane(v.y, i)), double(get_lane(v.z, i))};
        };
        const Vec3<double> from = lane_of(a), to = lane_of(b);
        const Level<double> sphere = sphere_level({0, 0, 0}, dot(to, to) < dot(from, from) ? job_.inner_escape_radius : job_.escape_radius);
        landing.wait(flow_, i, sphere, 0, 1, chord_fraction(sphere, from, to, 1));
    }
}

template <class V>
void PacketTracer<V>::land(Landing<V>& landing) {
    if (!landing.waiting) return;
    const Stopwatch watch(job_.timed, counters_.landing_ticks);
    landing.land([this](Flow<V>& f) { task_.begin(f); }, [this](Flow<V>& f) { task_.step(f); }, job_.hit == HitModel::chord);
    if (flow_.want_energy) worst_energy_ = max(worst_energy_, landing.flow.energy_error);
    for (std::uint64_t rest = landing.waiting; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if ((landing.lost >> i) & 1) {
            retire(landing.flow, i, Status::failed, Failure::not_converged);
            continue;
        }
        const bool hit = (fell_on_surface_ >> i) & 1;
        retire(landing.flow, i, hit ? Status::hit : Status::escaped, Failure::none);
        if (hit) ends_[i]->surface = surface_[i], ends_[i]->primitive = primitive_[i];
        ends_[i]->unrefined = (landing.unrefined >> i) & 1;
    }
}

/// Ends a ray that starts so far out that its numbers may not fit the packet's.
template <class V>
void PacketTracer<V>::retire_far_out(const RayStart& start, int lane) {
    retire(flow_, lane, Status::escaped, Failure::none);
    RayEnd& e = *ends_[lane];
    const double inverse = 1 / norm(Vec3<double>{start.p[0], start.p[1], start.p[2]});
    for (int k = 0; k < 3; ++k) e.q[k] = start.q[k], e.p[k] = start.p[k], e.v[k] = start.p[k] * inverse;
    e.pt = start.pt, e.parameter = e.energy_error = 0;
}

}  // namespace kagero

#include "kernels/tracing/ray_ends.h"
