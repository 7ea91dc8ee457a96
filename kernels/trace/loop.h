/// The tracing loop: rays in lockstep, each lane leaving when its own ray ends.
///
/// Compiled once per value type; scalar, and packets of any width, run these lines. The Hamiltonian and the method are behind
/// `SpaceKernel`. A finished lane keeps a harmless state and a step of length zero, so steppers need no masks.
#pragma once

#include "kernels/assertion.h"
#include "kernels/events/encounter.h"
#include "kernels/events/landing.h"
#include "kernels/trace/ray_source.h"
#include "kernels/methods/task.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// Finite exactly where state and velocity are (short of sums that overflow, which nothing survives either).
template <class V>
KAGERO_INLINE V sum_of_all(const State<V>& s, const Vec3<V>& v) {
    return (v.x + v.y + v.z) + (s.y[0] + s.y[1] + s.y[2]) + (s.y[3] + s.y[4] + s.y[5]);
}

/// The rays of one packet from start to end: `start`, as many calls of `step` as the longest of them needs, `finish`.
template <class V>
class PacketTracer {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    PacketTracer(const Task<V>& task, Counters& counters)
        : task_(task), job_(task.job), counters_(counters),
          bounds_steps_(task.straight || task.kernel.scaled || std::isfinite(task.job.bends_within) || std::isfinite(task.job.parameter_limit)) {}

    /// Takes a packet's worth of rays from the queue, and goes the short ways with those that have one.
    void start(RayQueue<W>& queue) {
        if (job_.geometry) encounter_.emplace(task_);
        active_before_ = counters_.active_lane_steps, issued_before_ = counters_.issued_lane_steps;
        if (!fill(queue)) return;
        if (encounter_) encounter_->begin(active_);
        if (task_.in_closed_form()) end_straight();
        if (task_.passes() && active_) pass();
        if (active_) landing_.emplace(task_);
    }
    /// Whether any ray goes on. When none does those that wait are landed, and what cannot land goes on from where its last step began.
    bool goes_on() {
        if (!active_ && landing_) land();
        return active_ != 0;
    }
    /// One step; into lanes that are done new rays come, where the job wants them.
    void step(RayQueue<W>& queue) {
        constexpr int enough = W - (W + 3) / 4;  // a few at a time: to refill costs about as much as a step
        advance_once();
        while (job_.refill && !task_.passes() && !task_.in_closed_form() && !queue.empty() && __builtin_popcountll(active_) <= enough) refill(queue);
    }
    /// Counts a step that others take while all rays here are done.
    void idle() { counters_.issued_lane_steps += W; }
    /// Tells what can be told only when no ray goes on.
    void finish() {
        if (!filled_) return;
        if (landing_) tell_occupancy(filled_);
        if (encounter_) counters_.query_ticks += encounter_->ticks;
        counters_.issued_iterations += flow_.issued_iterations * W;
    }

private:
    void end_straight();
    void pass();
    bool fill(RayQueue<W>& queue);
    void refill(RayQueue<W>& queue);
    void put(RayStarts<W>& starts, std::uint64_t lanes, Flow<V>& flow) const;
    void enter(const RayStarts<W>& starts, std::uint64_t lanes);
    void advance_once();
    std::uint64_t stopped(std::uint64_t moving) const;
    void count(std::uint64_t moving);
    std::uint64_t leave(std::uint64_t& moving);
    std::uint64_t repeat_to_crease(std::uint64_t moving);
    V length_to_crease(std::uint64_t lanes, const V& first);
    std::uint64_t not_yet_rejected(std::uint64_t lanes) const;
    void retry(std::uint64_t bad, std::uint64_t unsolved, std::uint64_t lossy);
    void repeat(std::uint64_t lanes, const V& length);
    void restart(std::uint64_t lanes, const V& length);
    MaskOf<V> is_beyond(const Vec3<V>& q) const;
    MaskOf<V> reaches_sphere(const Vec3<V>& q) const;
    MaskOf<V> leaves_space(const Vec3<V>& q, const Vec3<V>& v) const;
    std::uint64_t end_at_edge(std::uint64_t lanes);
    void fail(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t lossy);
    void drop(std::uint64_t lanes);
    void retire_far_out(const RayStarts<W>& starts, int lane);
    void make_harmless(std::uint64_t lanes);
    void set_out(std::uint64_t lanes);
    void commit(std::uint64_t lanes, std::uint64_t staying);
    void forget_repetitions(std::uint64_t lanes);
    std::uint64_t wait_for_surface(std::uint64_t hits);
    std::uint64_t excursions(std::uint64_t lanes, V& exit, V& farthest) const;
    void leave_sphere(std::uint64_t lanes);
    void wait_for_sphere(const Waypoint<V>& from, const Waypoint<V>& to, const V& place, std::uint64_t lanes);
    void wait_for_edge(std::uint64_t lanes, Edge edge);
    void note_direction(std::uint64_t lanes);
    std::uint64_t come_back(const Leg<V>& landed) const;
    void land();
    void land_once(bool more);
    std::uint64_t go_back(std::uint64_t lanes);
    void retire(const Flow<V>& f, std::uint64_t lanes, Status status, Failure failure = Failure::none);
    void write_ends(const Flow<V>& f, std::uint64_t lanes, Status status, Failure failure);
    void tell_iterations(int lane, const V& now);
    float occupancy_so_far() const;
    void tell_occupancy(std::uint64_t lanes);
    void report_path(const Flow<V>& f, std::uint64_t lanes, bool at_start);
    V step_length() const { return bounds_steps_ ? bounded_step_length() : nominal_; }
    V bounded_step_length() const;
    V longest_leap() const;
    V straight_way_out() const;
    V straight_way_in() const;

    const Task<V>& task_;
    const Job& job_;
    Counters& counters_;
    const bool bounds_steps_;                ///< a step may have another length than the job's, or the method's
    std::optional<Encounter<V>> encounter_;  ///< where there is anything to meet
    std::optional<Landing<V>> landing_;      ///< where steps are taken
    Flow<V> flow_;
    V nominal_;                     ///< step length of active lanes, 0 in finished ones
    V worst_energy_;
    V tried_h_, tried_side_;        ///< of lanes that search for the crease: their last try
    std::uint64_t active_ = 0;
    std::uint64_t repeated_ = 0;    ///< lanes that had to take their step again
    std::uint64_t outward_ = 0;     ///< lanes whose rays move away from the origin where their step starts
    V steps_;                       ///< whole numbers up to `most_counted`, exactly
    V iterations_after_;            ///< Flow::open_iterations when the lane's ray left to wait: idle lanes count on
    std::uint64_t active_before_ = 0, issued_before_ = 0;  ///< lane-steps, when the packet began
    std::uint64_t filled_ = 0;      ///< lanes that have, or had, a ray
    std::uint8_t halvings_[W] = {};
    std::uint16_t all_halvings_[W] = {};
    std::uint8_t rejections_[W] = {};
    std::uint32_t surface_[W], primitive_[W];  ///< of lanes that have met one
    std::uint64_t fell_on_surface_ = 0;
    RayEnd* ends_[W];
    std::uint64_t numbers_[W];

    /// Beyond it S does not tell a whole number from the next.
    static constexpr S most_counted = S(2) / machine_epsilon<S>;
    /// How often a step without solution is halved before its ray fails.
    static constexpr int max_halvings = 24;
    /// The same for all steps of a ray: one that creeps on by halvings alone would hardly ever end.
    static constexpr int most_halvings = 4000;
    /// How often in a row a step is taken again with another length before its ray fails.
    static constexpr int max_rejections = 60;
};

/// Whether places lie on the escape sphere or beyond it; or on that of the other universe.
template <class V>
KAGERO_INLINE MaskOf<V> PacketTracer<V>::reaches_sphere(const Vec3<V>& q) const {
    const V square = dot(q, q);
    const MaskOf<V> outer = square >= V(S(job_.escape_radius) * S(job_.escape_radius));
    if (!(job_.inner_escape_radius > 0)) return outer;
    return outer | (square <= V(S(job_.inner_escape_radius) * S(job_.inner_escape_radius)));
}

/// Whether rays at q that move along v are beyond the escape sphere, and do not come in; in a wormhole's other universe outward is inward.
template <class V>
MaskOf<V> PacketTracer<V>::leaves_space(const Vec3<V>& q, const Vec3<V>& v) const {
    const V outward = dot(q, v), square = dot(q, q);
    const MaskOf<V> here = (square >= V(S(job_.escape_radius) * S(job_.escape_radius))) & (outward >= V(S(0)));
    if (!(job_.inner_escape_radius > 0)) return here;
    return here | ((square <= V(S(job_.inner_escape_radius) * S(job_.inner_escape_radius))) & (outward < V(S(0))));
}

template <class V>
void PacketTracer<V>::advance_once() {
    KAGERO_ASSERT(active_ && (active_ & ~filled_) == 0);
    counters_.issued_lane_steps += W;
    counters_.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(active_));
    task_.step(flow_);
    const std::uint64_t finite = to_bits(is_finite(sum_of_all(flow_.end, flow_.end.velocity))), solved = to_bits(flow_.solved);
    const bool adaptive = task_.method.info.adaptive && !task_.straight;
    const std::uint64_t accepted = adaptive ? to_bits(flow_.accepted) : active_;
    // Beyond the medium's edge H means nothing.
    const std::uint64_t lossy = flow_.test_energy ? accepted & ~to_bits(flow_.energy_holds | (flow_.end.domain <= V(S(0)))) : 0;
    std::uint64_t moving = active_ & finite & solved & ~lossy;
    KAGERO_ASSERT((accepted & ~all_lanes<W>) == 0);
    if (moving != active_) retry(active_ & ~moving, active_ & ~solved, lossy & finite & solved);
    if (adaptive) {
        repeat(moving & ~accepted, flow_.suggested);
        moving &= accepted;
        nominal_ = pick(from_bits<V>(moving), flow_.suggested, nominal_);
    }
    if (task_.kernel.creased) moving &= ~repeat_to_crease(moving);
    const std::uint64_t leaving = leave(moving), staying = moving & ~leaving;
    if (job_.path_sink) report_path(flow_, staying, false);
    commit(moving, staying);
}

/// The lanes of `moving` whose step may have led to where a ray ends by itself, without meeting a surface, or reached its limits.
template <class V>
KAGERO_INLINE std::uint64_t PacketTracer<V>::stopped(std::uint64_t moving) const {
    if (std::isfinite(job_.parameter_limit)) return moving;
    MaskOf<V> going = (!reaches_sphere(flow_.end.q())) & (steps_ < V(std::min(S(job_.max_steps), most_counted)));
    if (task_.kernel.bounded) going = going & (flow_.end.domain > V(S(0)));
    if (task_.kernel.capturing) going = going & (flow_.end.captured > V(S(0)));
    return moving & ~to_bits(going);
}

/// Steps that are taken count.
template <class V>
KAGERO_INLINE void PacketTracer<V>::count(std::uint64_t moving) {
    const MaskOf<V> moved = from_bits<V>(moving);
    steps_ = pick(moved, steps_ + V(S(1)), steps_);
    if (flow_.want_energy) {
        const MaskOf<V> meant = moved & (flow_.end.domain > V(S(0)));
        worst_energy_ = pick(meant, max(worst_energy_, flow_.energy_error), worst_energy_);
    }
}

/// The lanes of `moving` whose rays end with this step: they wait for landing, or are retired at once. Those whose step is too long to be
/// tested against the scene take half of it, and move no more.
template <class V>
std::uint64_t PacketTracer<V>::leave(std::uint64_t& moving) {
    const Vec3<V> q = flow_.end.q();
    const std::uint64_t outward = to_bits(dot(q, flow_.end.velocity) > V(S(0)));
    V exit, farthest;
    std::uint64_t away = moving & outward_ & ~outward;
    if (away) away = excursions(away, exit, farthest);
    std::uint64_t tested = moving, hits = encounter_ ? encounter_->meet(flow_, tested) : 0;
    if (tested != moving) {
        repeat(moving & ~tested, V(S(0.5)) * flow_.h);
        moving = tested, away &= moving;
    }
    count(moving);
    std::uint64_t staying = moving;
    if (!(hits | away | stopped(moving))) {
        outward_ = (outward_ & ~moving) | (outward & moving);
        return 0;
    }
    if (away & hits) hits &= ~(away & to_bits(exit < encounter_->place()));
    staying &= ~wait_for_surface(hits);
    if (away &= staying) {
        landing_->wait(away, sphere_level(V(S(job_.escape_radius))), V(S(0)), farthest, exit);
        landing_->take(flow_, away);
    }
    staying &= ~away;
    const std::uint64_t beyond = task_.kernel.bounded ? staying & to_bits(flow_.end.domain <= V(S(0))) : 0;
    if (beyond) wait_for_edge(beyond, Edge::domain);
    staying &= ~beyond;
    std::uint64_t outside = staying & to_bits(reaches_sphere(q));
    if (outside) outside &= to_bits(leaves_space(q, flow_.end.velocity) | !is_beyond(flow_.start.q()));
    if (outside) leave_sphere(outside);
    staying &= ~outside;
    const std::uint64_t captured = task_.kernel.capturing ? staying & to_bits(flow_.end.captured <= V(S(0))) : 0;
    if (captured) wait_for_edge(captured, Edge::capture);
    staying &= ~captured;
    std::uint64_t limited = 0;
    if (std::isfinite(job_.parameter_limit)) {
        const S limit = S(job_.parameter_limit);
        limited = staying & to_bits(flow_.end.parameter >= V(limit * (1 - 4 * machine_epsilon<S>)));
        flow_.end.parameter = pick(from_bits<V>(limited), V(limit), flow_.end.parameter);
    }
    limited |= staying & to_bits(steps_ >= V(std::min(S(job_.max_steps), most_counted)));
    retire(flow_, limited, Status::step_limit);
    staying &= ~limited;
    outward_ = (outward_ & ~staying) | (outward & staying);
    return moving & ~staying;
}

/// Whether rays move away from the origin, where their step starts.
template <class V>
void PacketTracer<V>::note_direction(std::uint64_t lanes) {
    const std::uint64_t outward = to_bits(dot(flow_.start.q(), flow_.start.velocity) > V(S(0)));
    outward_ = (outward_ & ~lanes) | (outward & lanes);
}

/// The step of `lanes` becomes the start of the next for those that stay.
template <class V>
void PacketTracer<V>::commit(std::uint64_t lanes, std::uint64_t staying) {
    KAGERO_ASSERT((staying & ~lanes) == 0 && (lanes & ~active_) == 0);
    if (staying == all_lanes<W>) {
        task_.go_on(flow_);
        flow_.h = step_length();
        forget_repetitions(staying);
        return;
    }
    if (const std::uint64_t leaving = lanes & ~staying) {
        active_ &= ~leaving;
        iterations_after_ = pick(from_bits<V>(leaving), flow_.open_iterations, iterations_after_);
        nominal_ = pick(from_bits<V>(leaving), V(S(0)), nominal_);
    }
    const MaskOf<V> go = from_bits<V>(staying), done = from_bits<V>(~active_);
    task_.go_on(flow_, go);
    flow_.h = pick(go | done, step_length(), flow_.h);
    forget_repetitions(staying);
}

template <class V>
void PacketTracer<V>::forget_repetitions(std::uint64_t lanes) {
    for (const int i : lanes_in(lanes & repeated_))
        halvings_[i] = rejections_[i] = 0;
    repeated_ &= ~lanes;
}

}  // namespace kagero
