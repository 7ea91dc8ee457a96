/// Finds the exact places of events and moves rays there.
///
/// Dense output finds a surface, but its order is lower than that of the method. So the step is taken again, up to the
/// fraction where the surface lies, and Newton's method finds the rest of the way, in steps so short that a cheap
/// method can take them
/// (`Task::correction_step`): position and direction have the full order of the integrator.
#pragma once

#include "kernels/events/deferred_events.h"

#include <type_traits>

namespace kagero {

template <class V, class Events = AllEvents>
class EventRefiner {
    using S = ScalarOf<V>;

public:
    DeferredEvents<V, Events> deferred;  ///< after `refine`, deferred.step.end is where the rays are
    Step<V> whole;                       ///< after `refine`, the whole steps
    std::uint64_t unreached =
        0;  ///< lanes whose partial step fails or never arrives: their whole step was far too long
    std::uint64_t unrefined = 0;  ///< lanes whose place is only that of the chord

    explicit EventRefiner(const Task<V>& task) : task_(task) {}

    /// Moves all deferred rays to their events. With `hit = "chord"` that is where the chord of the step meets them.
    void refine() {
        DeferredEvents<V, Events>& d = deferred;
        const MaskOf<V> mask = from_bits<V>(d.lanes);
        d.guess = select(mask, d.guess, V(S(0)));
        const V full = select(mask, d.step.h, V(S(0)));
        d.step.h = full;
        whole = d.step;
        unreached = unrefined = lost_energy_ = 0;
        if (on_chord()) return interpolate(mask);
        if (!task_.own_curve) d.curve = Curve<V>::hermite(d.step);
        const Vec3<V> begin = d.curve.at(d.lo), piece = d.curve.at(d.hi) - begin,
                      met = advance(begin, (d.guess - d.lo) / (d.hi - d.lo), piece);
        const V found = d.guess;
        const std::uint64_t by_value = lanes_by_value(), surfaces = d.lanes_of.template of<SurfaceHit>();
        falling_ = d.level.slope(met, piece) < V(S(0));
        d.guess = nearest_on_curve(found, mask & (abs(d.level.a) > V(S(0))) & !from_bits<V>(by_value), met, piece);
        refine_on_curve(mask & !from_bits<V>(by_value));
        if (by_value) refine_by_value(from_bits<V>(by_value), full);
        refine_by_level(mask, from_bits<V>(by_value), full);
        keep_grazing_hits(unreached & surfaces & ~lost_energy_, found, met, piece);
        // A place on an escape sphere that dense output could not confirm is good if the ray is on the sphere.
        const MaskOf<V> on_sphere = abs(d.level.value(d.step.end.q())) <= V(on_it) * sqrt(d.level.radius2);
        unreached |= unrefined & ~surfaces & ~to_bits(on_sphere), unrefined &= surfaces;
        check_spheres();
    }

    /// Lanes that have crossed another event on their way to where they have been refined, by that event. The place of
    /// a grazing hit or of a chord is not exact enough for such a test.
    LanesOfEvents<Events> earlier_events() const {
        LanesOfEvents<Events> earlier;
        if (on_chord()) return earlier;
        std::uint64_t lanes = deferred.lanes & ~(unreached | unrefined | last_events());
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::crossed_before(task_, whole.start, whole.end); }) {
                if (!lanes || !Event::exists(task_)) return;
                earlier.template of<Event>() =
                    lanes & to_bits(Event::crossed_before(task_, whole.start, deferred.step.end));
                lanes &= ~earlier.template of<Event>();
            }
        });
        return earlier;
    }
    /// Sets rays aside again, with their whole steps, for events between the start and where they have been refined.
    void defer_again(const LanesOfEvents<Events>& earlier) {
        deferred.clear();
        const std::uint64_t lanes = earlier.all();
        if (!lanes) return;
        const RayState<V> beyond = deferred.step.end;
        const V fraction = deferred.guess;
        Step<V>& step = deferred.step;
        step.take(whole, from_bits<V>(lanes));
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::crossed_before(task_, whole.start, whole.end); })
                if (const std::uint64_t of_event = earlier.template of<Event>())
                    deferred.template defer_before<Event>(task_, of_event, whole.start, beyond, fraction);
        });
    }

private:
    bool on_chord() const { return task_.job.hit == HitModel::chord; }
    /// The lanes whose event is refined by its value.
    std::uint64_t lanes_by_value() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// The lanes whose event has no other event before it.
    std::uint64_t last_events() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (!Event::may_follow_another) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// Each lane's value of its own event.
    V value_at(const RayState<V>& at) const {
        V value(S(1));
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>())
                    value = select(from_bits<V>(lanes), Event::value(whole.start, at), value);
        });
        return value;
    }
    /// A ray that is refined onto a sphere and moves back into the scene has left it earlier: its step was too long.
    void check_spheres() {
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::moves_back(deferred.step.end); })
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & ~unreached)
                    unreached |= lanes & to_bits(Event::moves_back(deferred.step.end));
        });
    }

    /// From the fraction s, which belongs to a place on the chord of a piece, to where the curve is nearest to that
    /// place. A long step moves faster in one part than in another, and the far side of a small ball may be as near as
    /// the side that was hit.
    V nearest_on_curve(V s, const MaskOf<V>& lanes, const Vec3<V>& on_chord, const Vec3<V>& piece) const {
        const DeferredEvents<V, Events>& d = deferred;
        MaskOf<V> open = lanes;
        for (int i = 0; i < 3 && any(open); ++i) {
            const V next = s - dot(d.curve.at(s) - on_chord, piece) / dot(d.curve.slope(s), piece), last = s;
            s = select(open & is_finite(next), min(max(next, d.lo), d.hi), s);
            open = open & (abs(s - last) > V(settled) * (d.hi - d.lo));
        }
        return s;
    }

    /// Newton's method on the dense output, within the piece that was hit; if the ends of the piece lie on both sides
    /// of the surface, between places that do.
    void refine_on_curve(const MaskOf<V>& smooth) {
        DeferredEvents<V, Events>& d = deferred;
        const V length = d.hi - d.lo, margin = V(S(0.25)) * length, half(S(0.5)), close = V(S(1.0 / 16)) * length;
        const V least = max(d.lo - margin, V(least_fraction)), greatest = d.hi + margin;
        const V side = d.level.value(d.curve.at(d.lo));
        const MaskOf<V> crossing = smooth & (side * d.level.value(d.curve.at(d.hi)) < V(S(0)));
        V s = d.guess, before = d.lo, behind = d.hi;
        MaskOf<V> open = smooth;
        for (int i = 0; i < max_corrections && any(open); ++i) {
            const Vec3<V> q = d.curve.at(s);
            const V value = d.level.value(q), next = s + d.level.way(q, d.curve.slope(s), falling_).length;
            const MaskOf<V> short_of = side * value > V(S(0));
            before = select(short_of, s, before), behind = select(short_of, behind, s);
            const V middle = half * (before + behind),
                    between = select((next >= before - close) & (next <= behind + close), next, middle);
            const V free = select(is_finite(next), min(max(next, least), greatest), s), last = s;
            s = select(open, select(crossing, between, free), s);
            // Without places on both sides, three steps have to do.
            open = open & (abs(s - last) > V(settled) * length);
            if (i >= 2) open = open & crossing;
        }
        const MaskOf<V> inside = (s > least) & (s < greatest);
        unrefined = to_bits(smooth & !inside);
        d.guess = select(smooth & inside, s, d.guess);
    }

    /// A partial step to where the surface should be, and Newton's corrections from there, towards the side of a ball
    /// that was hit. The step may end beyond the surface, because dense output shows less well how far a ray has come
    /// than where it leads. Each correction squares the error: after one that is shorter than the root of a rounding,
    /// what is left is straight, and `extrapolate` takes it. A lane that has arrived does not change any more, however
    /// long others take.
    ///
    /// The step to the place that dense output gives leaves a correction of order h³. To extrapolate it at once makes
    /// an error of order h⁵ in the momentum, which is no worse than the errors of a method of order five on its way. A
    /// symplectic method would lose some 1e-8 of what it conserves, and therefore takes the correction step in double.
    void refine_by_level(const MaskOf<V>& mask, const MaskOf<V>& by_value, const V& full) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V zero(S(0)), close = max(V(S(0.25) * std::sqrt(machine_epsilon<S>)), V(S(4)) * last_place(full)),
                            close_at_once = at_once(close);
        const MaskOf<V> all = mask & !by_value;
        MaskOf<V> moving = all, open = all & !from_bits<V>(unrefined);
        StepEnd<V> arrived = step;
        step.h = select(by_value, zero, d.guess * full);
        if (!task_.resumes) task_.begin(step);
        for (int i = 0; i < max_corrections; ++i) {
            if (i == 0) task_.step(step);
            else task_.correction_step(step);
            arrived.take(step, moving);
            const auto [rest, misses] = d.level.way(step.end.q(), step.end.velocity, falling_);
            const V s = max(min(d.guess + rest / full, V(greatest_fraction)), V(least_fraction));
            MaskOf<V> usable = step.solved & is_finite(rest) & is_finite(sum_of_momenta(step.end));
            if (i >= 2) usable = usable & !misses;  // from far off the surface, the tangent of a ray may miss it
            if (step.options.test_energy) lost_energy_ |= to_bits(open & usable & !step.energy_holds);
            unreached |= to_bits(open & !usable) | lost_energy_;
            open = open & usable & !from_bits<V>(lost_energy_);
            const MaskOf<V> there = open & !misses & (abs(s - d.guess) <= (i > 0 ? close : close_at_once));
            if (any(there)) extrapolate(arrived, (s - d.guess) * full, there);
            d.guess = select(there, s, d.guess), open = open & !there;
            if (!any(open)) break;
            task_.begin_next(step, mask);
            moving = open;
            step.h = select(open, (s - d.guess) * full, zero);
            d.guess = select(open, s, d.guess);
        }
        unreached |= to_bits(open);
        static_cast<StepEnd<V>&>(step).take(arrived, mask);
    }
    V at_once(const V& close) const {
        const IntegratorInfo& method = task_.method.info;
        if (method.order <= 5 && !method.symplectic && !task_.straight) return max(V(S(1e-3)), close);
        return std::is_same_v<S, float> ? close : V(S(0));
    }
    static V sum_of_momenta(const State<V>& state) {
        const Vec3<V> p = state.p();
        return p.x + p.y + p.z;
    }
    /// The rounding of a position as a fraction of the step: far from the origin, the place on the step is not known
    /// better.
    V last_place(const V& full) const {
        const Vec3<V> q = deferred.step.end.q(), &v = whole.start.velocity;
        const V far = max(max(abs(q.x), abs(q.y)), abs(q.z)), speed = max(max(abs(v.x), abs(v.y)), abs(v.z));
        const V place = V(machine_epsilon<S>) * far / (speed * abs(full));
        return select(is_finite(place), place, V(S(0)));
    }

    /// Moves rays by a small length beyond the last step: positions by the velocity at its end, as it changed in the
    /// step, everything else at the rate of the step; no farther than the step itself, or roundings would be magnified.
    void extrapolate(StepEnd<V>& arrived, const V& length, const MaskOf<V>& lanes) {
        const StepperState<V>& step = deferred.step;
        const Level<V>& level = deferred.level;
        const V one(S(1)), zero(S(0)), left = select(lanes, length, zero);
        const V share = select(lanes & (abs(step.h) > zero), max(min(left / step.h, one), -one), zero);
        const Vec3<V> mean = advance(step.end.velocity, V(S(0.5)) * share, step.end.velocity - step.start.velocity);
        const Vec3<V> q = advance(arrived.end.q(), left, mean);
        const V beside = level.value(q) / level.slope(q, step.end.velocity),
                way = select(lanes & is_finite(beside), left - beside, left);
        const auto further = [&](const V& from, const V& to, V& end) { end = fma(share, to - from, end); };
        arrived.end.set(advance(arrived.end.q(), way, mean), arrived.end.p());
        for (int k = 0; k < space_size; ++k)
            further(step.start.y[momentum(k)], step.end.y[momentum(k)], arrived.end.y[momentum(k)]);
        further(step.start.velocity.x, step.end.velocity.x, arrived.end.velocity.x);
        further(step.start.velocity.y, step.end.velocity.y, arrived.end.velocity.y);
        further(step.start.velocity.z, step.end.velocity.z, arrived.end.velocity.z);
        further(step.start.parameter, step.end.parameter, arrived.end.parameter);
    }

    /// The zero of each lane's value by the secant method, always from the start of the step: beyond the event the
    /// state may be meaningless. Where the secant hardly moves any more, the next try goes a little farther: the event
    /// lies between two places that are so close, or else the step is discontinuous there. Other lanes keep their end.
    void refine_by_value(const MaskOf<V>& lanes, const V& full) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V close(S(16) * machine_epsilon<S>), zero(S(0));
        MaskOf<V> open = lanes;
        V last_s(zero), last_value = value_at(step.start), before(zero), after = select(lanes, d.hi, V(S(1))),
                        reach = close;
        for (int i = 0; i < max_corrections; ++i) {
            if (!task_.resumes)
                task_.begin(step);  // every time: the result of a lane must not depend on how long others take
            step.h = select(lanes, d.guess * full, zero);
            const V gradients = step.gradients;
            task_.step(step);
            step.gradients = select(open, step.gradients, gradients);
            const V value = value_at(step.end), secant = d.guess - value * (d.guess - last_s) / (value - last_value);
            before = select(value > zero, d.guess, before), after = select(value > zero, after, d.guess);
            const MaskOf<V> resting = abs(secant - d.guess) < reach;
            const V farther = select(resting, d.guess + select(value > zero, reach, -reach), secant);
            reach = select(resting, V(S(4)) * reach, reach);  // where roundings hide on which side a place is
            const V next = select((farther > before) & (farther <= after), farther, V(S(0.5)) * (before + after));
            last_s = d.guess, last_value = value;
            const MaskOf<V> usable = is_finite(next) & is_finite(sum_of_momenta(step.end));
            unreached |= to_bits(open & !usable);
            open = open & usable & (after - before > V(S(2)) * reach);
            if (!any(open)) break;
            if (i + 1 == max_corrections) unreached |= to_bits(open & (after - before > V(discontinuous) * close));
            else d.guess = select(open, next, d.guess);
        }
        if (step.options.test_energy) unreached |= to_bits(lanes & !(step.solved & step.energy_holds));
        end_certain_events();
        task_.begin_next(step, lanes);
    }
    /// Rays of events that are certain end at the end of their whole step where the refinement fails.
    void end_certain_events() {
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) {
                if (!Event::certain) return;
                const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & unreached;
                static_cast<StepEnd<V>&>(deferred.step).take(whole, from_bits<V>(lanes));
                unreached &= ~lanes;
            }
        });
    }

    /// A chord may hit a surface that the curve just misses: where the curve comes as close as that, the hit of the
    /// chord is kept.
    void keep_grazing_hits(std::uint64_t lanes, const V& found, const Vec3<V>& on_chord, const Vec3<V>& piece) {
        if (!lanes) return;
        DeferredEvents<V, Events>& d = deferred;
        const Vec3<V> way = whole.end.q() - whole.start.q();
        const V closest = nearest_on_curve(found, from_bits<V>(lanes), on_chord, piece),
                away = d.level.value(d.curve.at(closest)), near(grazes);
        const std::uint64_t grazing = lanes & to_bits(away * away <= near * near * dot(way, way));
        const MaskOf<V> here = from_bits<V>(grazing);
        d.guess = select(here, closest, d.guess);
        interpolate(here);
        d.step.end.set(select<V>(here, on_chord, d.step.end.q()), d.step.end.p());
        unrefined |= grazing;
        unreached &= ~grazing;
    }

    /// Moves rays along the chord of the whole step.
    void interpolate(const MaskOf<V>& mask) {
        const V& s = deferred.guess;
        RayState<V>& end = deferred.step.end;
        const Vec3<V> way = whole.end.q() - whole.start.q();
        for (int k = 0; k < phase_size; ++k)
            end.y[k] = select(mask, fma(s, whole.end.y[k] - whole.start.y[k], whole.start.y[k]), end.y[k]);
        end.parameter =
            select(mask, fma(s, whole.end.parameter - whole.start.parameter, whole.start.parameter), end.parameter);
        end.velocity = select<V>(mask, way, end.velocity);
    }

    static constexpr int max_corrections = 30;
    /// Newton's method on dense output ends where it moves by less than this share of the piece: the next step squares
    /// the error.
    static constexpr S settled = S(1e-3);
    /// A ray is on a sphere if its distance from the sphere is less than this share of the radius.
    static constexpr S on_it = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
    /// A step is discontinuous if the places before and after an event come no closer than this many times `close`.
    static constexpr S discontinuous = 1024;
    /// A curve grazes a surface that its chord hits if it comes as close as this share of the step's chord.
    static constexpr S grazes = S(0.01);
    /// Fractions of a step within which its event is searched; what lies before the start was found in the step before.
    static constexpr S least_fraction = S(-1e-3), greatest_fraction = S(1.25);

    const Task<V>& task_;
    MaskOf<V> falling_;        ///< lanes that approach their level from where its function is positive
    std::uint64_t lost_energy_ = 0;  ///< lanes that lost H in their partial step
};

}  // namespace kagero
