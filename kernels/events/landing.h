/// Delivering rays onto what ends them: a surface, the escape sphere, or the edge of the medium.
///
/// Dense output finds the event; its order is lower than the step's. So a ray that has met something waits, with the step it was
/// taking, until the rest of its packet is done; then all of them redo that step at the fraction where the surface lies, and go the
/// rest of the way, which Newton's method tells, in steps so short that a cheap method takes them (`Task::creep`): position and direction
/// have the full order of the integrator.
#pragma once

#include "kernels/intersection/surface.h"
#include "kernels/methods/task.h"

#include <type_traits>

namespace kagero {

/// What ends a ray without being a surface: a number of its own that falls to zero.
enum class Edge : std::uint8_t { domain, capture, turn };  ///< turn: where a ray that passes by is nearest to the origin, or farthest from it

template <class V>
class Landing {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    Flow<V> flow;              ///< the waiting lanes' last steps; after `land` flow.end is where they stand
    std::uint64_t waiting = 0;
    std::uint64_t unrefined = 0;
    std::uint64_t captured = 0;
    std::uint64_t lost = 0;    ///< lanes whose partial step has no solution, loses H, or never arrives: the step was far too long
    Leg<V> whole;              ///< after `land` the waiting lanes' last steps, all of them

    explicit Landing(const Task<V>& task) : task_(task) {}

    /// Nobody waits any more.
    void clear() {
        waiting = unrefined = lost = captured = edge_ = turning_ = lossy_ = 0;
        level_.curved = false;
    }

    /// The step of `from` for the lanes that have been told to wait since the last call.
    void take(const Flow<V>& from, std::uint64_t lanes) {
        Leg<V>& leg = flow;
        if (waiting == lanes) leg = from;  // every other lane holds something harmless
        else leg.take(from, from_bits<V>(lanes));
        if (task_.own_curve) take_curve(task_.curve(from), from_bits<V>(lanes));
    }
    /// Lanes that meet `level` within fractions [lo, hi] of their step, probably at s.
    void wait(std::uint64_t lanes, const Level<V>& level, const V& lo, const V& hi, const V& s) {
        const MaskOf<V> here = from_bits<V>(lanes);
        level_.take(here, level);
        lo_ = pick(here, lo, lo_), hi_ = pick(here, hi, hi_), s_ = pick(here, s, s_);
        waiting |= lanes;
    }
    /// Lanes that leave the medium during their step, or are captured, or turn: where the Hamiltonian's `domain`, or `captured`, falls to
    /// zero, or the way along the radius. The step starts at `start`; `beyond` the edge they are at the fraction `place` of it.
    void wait_for_edge(const Waypoint<V>& start, const Waypoint<V>& beyond, const V& place, std::uint64_t lanes, Edge edge) {
        const auto height = [&](const Waypoint<V>& at) {
            return edge == Edge::turn ? along_radius(start, at) : edge == Edge::capture ? at.captured : at.domain;
        };
        const V inside = height(start), outside = height(beyond);
        wait(lanes, Level<V>::none(), V(S(0)), place, place * inside / (inside - outside));
        edge_ |= lanes;
        if (edge == Edge::capture) captured |= lanes;
        if (edge == Edge::turn) turning_ |= lanes;
    }

    /// Everybody who waits to where the level is, which is a surface for those of `surfaces`; with `hit = "chord"` to where the chord meets it.
    void land(std::uint64_t surfaces) {
        const MaskOf<V> mask = from_bits<V>(waiting);
        s_ = pick(mask, s_, V(S(0)));
        const V full = pick(mask, flow.h, V(S(0)));
        flow.h = full;
        whole = flow;
        if (task_.job.hit == HitModel::chord) return interpolate(mask);
        if (!task_.own_curve) curve_ = Curve<V>::hermite(flow);
        const Vec3<V> begin = curve_.at(lo_), piece = curve_.at(hi_) - begin, on_chord = advance(begin, (s_ - lo_) / (hi_ - lo_), piece);
        const V met = s_;
        falling_ = level_.slope(on_chord, piece) < V(S(0));
        s_ = beside(met, mask & (abs(level_.a) > V(S(0))) & !from_bits<V>(edge_), on_chord, piece);
        refine_on_curve(mask);
        if (edge_) deliver_to_edge(full);
        deliver(mask, full);
        keep_grazing_hits(surfaces, met, on_chord, piece);
        // What dense output does not tell of the escape sphere stands where the landing is on it.
        const MaskOf<V> on_it = abs(level_.value(flow.end.q())) <= V(S(beyond_doubt)) * sqrt(level_.radius2);
        lost |= unrefined & ~surfaces & ~to_bits(on_it), unrefined &= surfaces;
    }

    /// The lanes that have landed on the escape sphere: on no edge, and on none of `surfaces`, which are all that have met one.
    std::uint64_t on_sphere(std::uint64_t surfaces) const {
        return task_.job.hit == HitModel::chord ? 0 : waiting & ~(lost | edge_ | surfaces);
    }
    /// Of lanes that have landed, those that crossed another edge before: there its number has fallen below zero.
    std::uint64_t landed_beyond(Edge edge) const {
        if (task_.job.hit == HitModel::chord) return 0;
        const V& before = edge == Edge::capture ? whole.start.captured : whole.start.domain;
        const V& height = edge == Edge::capture ? flow.end.captured : flow.end.domain;
        return waiting & ~(lost | unrefined | turning_) & to_bits(height < V(S(-beyond_doubt)) * abs(before));
    }
    /// The same of the escape sphere, for those that started within it.
    std::uint64_t landed_beyond(S radius) const {
        if (task_.job.hit == HitModel::chord) return 0;
        const Vec3<V> a = whole.start.q(), q = flow.end.q();
        const V square(radius * radius);
        return waiting & ~(lost | unrefined | turning_) & to_bits((dot(a, a) < square) & (dot(q, q) > V(S(1 + beyond_doubt)) * square));
    }
    /// Where on their step lanes have landed, as fractions.
    const V& place() const { return s_; }
    /// Lanes take up the whole of their step again, to land elsewhere on it.
    void take_again(std::uint64_t lanes) {
        Leg<V>& leg = flow;
        leg.take(whole, from_bits<V>(lanes));
    }

private:
    /// How fast a ray goes along the radius, > 0 the way it went at the start of its step.
    static V along_radius(const Waypoint<V>& start, const Waypoint<V>& at) {
        const V speed = dot(at.q(), at.velocity);
        return pick(dot(start.q(), start.velocity) > V(S(0)), speed, -speed);
    }

    void take_curve(const Curve<V>& from, const MaskOf<V>& lanes) {
        curve_.degree = from.degree;
        for (int i = 0; i <= from.degree; ++i) curve_.point[i] = pick<V>(lanes, from.point[i], curve_.point[i]);
    }

    /// From the fraction s of the piece's chord that was hit to where the curve is beside it: a long step goes faster here than there, and the
    /// far side of a small ball may be as near as the one that was hit.
    V beside(V s, const MaskOf<V>& lanes, const Vec3<V>& on_chord, const Vec3<V>& piece) const {
        MaskOf<V> open = lanes;
        for (int i = 0; i < 3 && any(open); ++i) {
            const V next = s - dot(curve_.at(s) - on_chord, piece) / dot(curve_.slope(s), piece), last = s;
            s = pick(open & is_finite(next), min(max(next, lo_), hi_), s);
            open = open & (abs(s - last) > V(settled) * (hi_ - lo_));
        }
        return s;
    }

    /// Newton on the dense output, kept inside the piece that was hit; where the ends of that lie on both sides of the surface, between places
    /// that do.
    void refine_on_curve(const MaskOf<V>& mask) {
        const V length = hi_ - lo_, margin = V(S(0.25)) * length, least = max(lo_ - margin, V(least_fraction)), greatest = hi_ + margin, half(S(0.5));
        const V side = level_.value(curve_.at(lo_)), close = V(S(1.0 / 16)) * length;
        const MaskOf<V> smooth = mask & !from_bits<V>(edge_), crossing = smooth & (side * level_.value(curve_.at(hi_)) < V(S(0)));
        V s = s_, before = lo_, behind = hi_;
        MaskOf<V> open = smooth;
        for (int i = 0; i < max_corrections && any(open); ++i) {
            const Vec3<V> q = curve_.at(s);
            const V value = level_.value(q), next = s + level_.way(q, curve_.slope(s), falling_).length;
            const MaskOf<V> short_of = side * value > V(S(0));
            before = pick(short_of, s, before), behind = pick(short_of, behind, s);
            const V middle = half * (before + behind), between = pick((next >= before - close) & (next <= behind + close), next, middle);
            const V free = pick(is_finite(next), min(max(next, least), greatest), s), last = s;
            s = pick(open, pick(crossing, between, free), s);
            // Without places on both sides three steps must do.
            open = open & (abs(s - last) > V(settled) * length);
            if (i >= 2) open = open & crossing;
        }
        const MaskOf<V> inside = (s > least) & (s < greatest);
        unrefined = to_bits(smooth & !inside);
        s_ = pick(smooth & inside, s, s_);
    }

    /// A partial step to where the surface should be, and from there Newton's corrections, to that side of a ball which was met: the step may
    /// end beyond it, as dense output tells less well how far along its way a ray is than where that leads. Each squares the error, so that of the one
    /// shorter than the root of a rounding nothing is left but what is straight: it goes on as the correction before it went. A lane
    /// that has arrived stays there to the last bit, however long others take.
    ///
    /// Of the step to the place that dense output tells, a correction of order h³ of it is left, and an error of order h⁵ in the momentum
    /// by going on at once: no worse than what a method of order five has gathered on its way. A symplectic one would lose some 1e-8 of
    /// what it conserves, and so in double takes the step.
    void deliver(const MaskOf<V>& mask, const V& full) {
        const IntegratorInfo& method = task_.method.info;
        const V zero(S(0)), close = max(V(S(0.25) * std::sqrt(machine_epsilon<S>)), V(S(4)) * last_place(full));
        const V close_at_once = method.order <= 5 && !method.symplectic && !task_.straight ? max(V(S(1e-3)), close) : std::is_same_v<S, float> ? close : zero;
        const MaskOf<V> edge = from_bits<V>(edge_);
        const MaskOf<V> all = mask & !edge;
        MaskOf<V> moving = all, open = all & !from_bits<V>(unrefined);
        Arrival<V> arrived = flow;
        flow.h = pick(edge, zero, s_ * full);
        if (!task_.resumes) task_.begin(flow);
        for (int i = 0; i < max_corrections; ++i) {
            if (i == 0) task_.step(flow);
            else task_.creep(flow);
            arrived.take(flow, moving);
            const auto [rest, misses] = level_.way(flow.end.q(), flow.end.velocity, falling_);
            const V s = max(min(s_ + rest / full, V(greatest_fraction)), V(least_fraction));
            MaskOf<V> usable = flow.solved & is_finite(rest) & is_finite(flow.end.y[3] + flow.end.y[4] + flow.end.y[5]);
            if (i >= 2) usable = usable & !misses;  // from far off the surface a ray's tangent may
            if (flow.test_energy) lossy_ |= to_bits(open & usable & !flow.energy_holds);
            lost |= to_bits(open & !usable) | lossy_;
            open = open & usable & !from_bits<V>(lossy_);
            const MaskOf<V> there = open & !misses & (abs(s - s_) <= (i > 0 ? close : close_at_once));
            if (any(there)) go_further(arrived, (s - s_) * full, there);
            s_ = pick(there, s, s_), open = open & !there;
            if (!any(open)) break;
            task_.go_on(flow, mask);
            moving = open;
            flow.h = pick(open, (s - s_) * full, zero);
            s_ = pick(open, s, s_);
        }
        lost |= to_bits(open);
        static_cast<Arrival<V>&>(flow).take(arrived, mask);
    }

    /// Of the step: where a ray is so far out, its place says no more of where on the step it is.
    V last_place(const V& full) const {
        const Vec3<V> q = flow.end.q(), &v = whole.start.velocity;
        const V far = max(max(abs(q.x), abs(q.y)), abs(q.z)), speed = max(max(abs(v.x), abs(v.y)), abs(v.z));
        const V place = V(machine_epsilon<S>) * far / (speed * abs(full));
        return pick(is_finite(place), place, V(S(0)));
    }

    /// From the end of the step just taken a little further: places at the velocity there, as it changed in that step, all else at the rate
    /// that it had in it; no further than that went, or roundings would be stretched.
    void go_further(Arrival<V>& arrived, const V& length, const MaskOf<V>& lanes) {
        const V one(S(1)), zero(S(0)), left = pick(lanes, length, zero);
        const V share = pick(lanes & (abs(flow.h) > zero), max(min(left / flow.h, one), -one), zero);
        const Vec3<V> mean = advance(flow.end.velocity, V(S(0.5)) * share, flow.end.velocity - flow.start.velocity);
        const Vec3<V> q = advance(arrived.end.q(), left, mean);
        const V beside = level_.value(q) / level_.slope(q, flow.end.velocity), way = pick(lanes & is_finite(beside), left - beside, left);
        const auto further = [&](const V& from, const V& to, V& end) { end = mul_add(share, to - from, end); };
        arrived.end.set(advance(arrived.end.q(), way, mean), arrived.end.p());
        for (int k = 3; k < 6; ++k) further(flow.start.y[k], flow.end.y[k], arrived.end.y[k]);
        further(flow.start.velocity.x, flow.end.velocity.x, arrived.end.velocity.x);
        further(flow.start.velocity.y, flow.end.velocity.y, arrived.end.velocity.y);
        further(flow.start.velocity.z, flow.end.velocity.z, arrived.end.velocity.z);
        further(flow.start.parameter, flow.end.parameter, arrived.end.parameter);
    }

    /// Edges by the secant, always from the step's start: beyond them H means nothing. Where that hardly moves any more, a little farther than
    /// it says: the edge lies between two places so close, or else the step is discontinuous there. Other lanes stay where they are.
    void deliver_to_edge(const V& full) {
        const V close(S(16) * machine_epsilon<S>), zero(S(0));
        const MaskOf<V> edge = from_bits<V>(edge_), capture = from_bits<V>(captured), turning = from_bits<V>(turning_);
        const auto height_at = [&](const Waypoint<V>& at) {
            return pick(turning, along_radius(whole.start, at), pick(capture, at.captured, at.domain));
        };
        MaskOf<V> open = edge;
        V last_s(zero), last_height = height_at(flow.start), inside(zero), outside = pick(edge, hi_, V(S(1))), reach = close;
        for (int i = 0; i < max_corrections; ++i) {
            if (!task_.resumes) task_.begin(flow);  // every time: what a lane computes must not depend on how long others take
            flow.h = pick(edge, s_ * full, zero);
            const V before = flow.gradients;
            task_.step(flow);
            flow.gradients = pick(open, flow.gradients, before);
            const V height = height_at(flow.end);
            const V guess = s_ - height * (s_ - last_s) / (height - last_height);
            inside = pick(height > zero, s_, inside), outside = pick(height > zero, outside, s_);
            const MaskOf<V> resting = abs(guess - s_) < reach;
            const V farther = pick(resting, s_ + pick(height > zero, reach, -reach), guess);
            reach = pick(resting, V(S(4)) * reach, reach);  // where roundings hide on which side a place is
            const V next = pick((farther > inside) & (farther <= outside), farther, V(S(0.5)) * (inside + outside));
            last_s = s_, last_height = height;
            const MaskOf<V> usable = is_finite(next) & is_finite(flow.end.y[3] + flow.end.y[4] + flow.end.y[5]);
            lost |= to_bits(open & !usable);
            open = open & usable & (outside - inside > V(S(2)) * reach);
            if (!any(open)) break;
            if (i + 1 == max_corrections) lost |= to_bits(open & (outside - inside > V(torn) * close));
            else s_ = pick(open, next, s_);
        }
        if (flow.test_energy) lost |= to_bits(edge & !(flow.solved & flow.energy_holds));
        // A captured ray is captured even where its landing loses H.
        static_cast<Arrival<V>&>(flow).take(whole, from_bits<V>(lost & captured));
        lost &= ~captured;
        task_.go_on(flow, edge);
    }

    /// A chord may meet a surface that the curve just misses: where the curve comes as close as that, the chord's hit stands.
    void keep_grazing_hits(std::uint64_t surfaces, const V& met, const Vec3<V>& on_chord, const Vec3<V>& piece) {
        const std::uint64_t smooth = lost & surfaces & ~lossy_;
        if (!smooth) return;
        const Vec3<V> way = whole.end.q() - whole.start.q();
        const V closest = beside(met, from_bits<V>(smooth), on_chord, piece), away = level_.value(curve_.at(closest)), near(grazes);
        const std::uint64_t grazing = smooth & to_bits(away * away <= near * near * dot(way, way));
        const MaskOf<V> here = from_bits<V>(grazing);
        s_ = pick(here, closest, s_);
        interpolate(here);
        flow.end.set(pick<V>(here, on_chord, flow.end.q()), flow.end.p());
        unrefined |= grazing;
        lost &= ~grazing;
    }

    /// On the chord itself: straight-line interpolation between the ends of the whole step.
    void interpolate(const MaskOf<V>& mask) {
        const Vec3<V> way = whole.end.q() - whole.start.q();
        for (int k = 0; k < 6; ++k)
            flow.end.y[k] = pick(mask, mul_add(s_, whole.end.y[k] - whole.start.y[k], whole.start.y[k]), flow.end.y[k]);
        flow.end.parameter = pick(mask, mul_add(s_, whole.end.parameter - whole.start.parameter, whole.start.parameter), flow.end.parameter);
        flow.end.velocity = pick<V>(mask, way, flow.end.velocity);
    }

    static constexpr int max_corrections = 30;
    /// Of a piece: whoever moves less on dense output is there, as each of Newton's steps squares what is missing.
    static constexpr S settled = S(1e-3);
    /// Of what an edge's number is where the step starts: to less, landing does not tell which of two edges comes first.
    static constexpr S beyond_doubt = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
    /// Of `close`, to which the two places around an edge come together: where they stay so far apart the way is torn.
    static constexpr S torn = 1024;
    /// Of a step's chord: a curve so close to a surface that the chord meets has grazed it.
    static constexpr S grazes = S(0.01);
    /// Of a step, beyond which nothing is sought: what lies before its start was met by the step before.
    static constexpr S least_fraction = S(-1e-3), greatest_fraction = S(1.25);

    const Task<V>& task_;
    Curve<V> curve_;  ///< of the waiting lanes' last steps
    std::uint64_t edge_ = 0, turning_ = 0, lossy_ = 0;
    Level<V> level_ = Level<V>::none();
    MaskOf<V> falling_;  ///< lanes that come to their level from where it is positive
    V lo_ = S(0), hi_ = S(0), s_ = S(0);
};

}  // namespace kagero
