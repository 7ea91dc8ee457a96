/// Finds the exact positions of events and moves rays to them.
///
/// Dense output locates a surface, but its order is lower than the order of the method. The refiner therefore repeats
/// the step with the length up to the surface, and corrects the end by Newton's method. The correction steps are so
/// short that a cheap method suffices (`Task::correction_step`). Position and direction at the event have the full
/// order of the method.
#pragma once

#include "kernels/events/deferred_events.h"

#include <type_traits>

namespace kagero {

/// Refines the deferred events of one packet.
template <class V, class Events = AllEvents>
class EventRefiner {
    using S = ScalarOf<V>;

public:
    DeferredEvents<V, Events> deferred;  ///< After `refine`, deferred.step.end is the state at the event.
    Step<V> whole;                       ///< After `refine`, the whole steps.
    std::uint64_t unreached = 0;  ///< Lanes whose refinement failed, because their whole step is far too long.
    std::uint64_t unrefined = 0;  ///< Lanes whose event position has only the accuracy of a chord.

    explicit EventRefiner(const Task<V>& task) : task_(task) {}

    /// Moves all deferred rays to their events. With `hit = "chord"`, events lie on the chord of the step.
    void refine() {
        DeferredEvents<V, Events>& d = deferred;
        const MaskOf<V> mask = from_bits<V>(d.lanes);
        d.guess = select(mask, d.guess, V(S(0)));
        const V full_length = select(mask, d.step.h, V(S(0)));
        d.step.h = full_length;
        whole = d.step;
        unreached = unrefined = lost_energy_ = 0;
        if (on_chord()) return interpolate(mask);
        if (!task_.own_curve) d.curve = Curve<V>::hermite(d.step);
        const Vec3<V> piece_start = d.curve.at(d.lo), piece = d.curve.at(d.hi) - piece_start,
                      chord_point = advance(piece_start, (d.guess - d.lo) / (d.hi - d.lo), piece);
        const V estimate = d.guess;
        const std::uint64_t by_value = lanes_by_value(), surfaces = d.lanes_of.template of<SurfaceHit>();
        decreasing_ = d.level_set.slope(chord_point, piece) < V(S(0));
        const MaskOf<V> spheres = mask & (abs(d.level_set.a) > V(S(0))) & !from_bits<V>(by_value);
        d.guess = nearest_on_curve(estimate, spheres, chord_point, piece);
        refine_on_curve(mask & !from_bits<V>(by_value));
        if (by_value) refine_by_value(from_bits<V>(by_value), full_length);
        refine_by_level_set(mask, from_bits<V>(by_value), full_length);
        keep_grazing_hits(unreached & surfaces & ~lost_energy_, estimate, chord_point, piece);
        // If dense output did not confirm a point on an escape sphere, the point is accepted if it lies on the sphere.
        const V distance = abs(d.level_set.value(d.step.end.q()));
        const MaskOf<V> on_sphere = distance <= V(sphere_tolerance) * sqrt(d.level_set.radius2);
        unreached |= unrefined & ~surfaces & ~to_bits(on_sphere);
        unrefined &= surfaces;
        check_spheres();
    }

    /// Returns the lanes that have crossed another event before their refined event, listed by the other event. The
    /// position of a grazing hit, or of an event on a chord, is not exact enough for this test.
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
    /// Replaces the deferred events by those of `earlier`, which lie between the start and the refined position.
    void defer_again(const LanesOfEvents<Events>& earlier) {
        deferred.clear();
        const std::uint64_t lanes = earlier.all();
        if (!lanes) return;
        const RayState<V> beyond = deferred.step.end;
        const V fraction = deferred.guess;
        deferred.step.copy_lanes(whole, from_bits<V>(lanes));
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::crossed_before(task_, whole.start, whole.end); })
                if (const std::uint64_t of_event = earlier.template of<Event>())
                    deferred.template defer_before<Event>(task_, of_event, whole.start, beyond, fraction);
        });
    }

private:
    bool on_chord() const { return task_.job.hit == HitModel::chord; }
    /// Returns the lanes whose event is defined by a value.
    std::uint64_t lanes_by_value() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// Returns the lanes whose event cannot follow another event on the same step.
    std::uint64_t last_events() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (!Event::may_follow_another) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// Returns, for each lane, the value of that lane's event.
    V value_at(const RayState<V>& at) const {
        V value(S(1));
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>())
                    value = select(from_bits<V>(lanes), Event::value(whole.start, at), value);
        });
        return value;
    }
    /// Marks rays as unreached that move back into an escape sphere at their refined position: they have left earlier.
    void check_spheres() {
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::moves_back(deferred.step.end); })
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & ~unreached)
                    unreached |= lanes & to_bits(Event::moves_back(deferred.step.end));
        });
    }

    /// Returns the fraction at which the curve crosses the plane through `chord_point` perpendicular to the chord
    /// `piece`. The initial guess is `s`, the fraction of `chord_point` on the chord. Since the speed varies along a
    /// long step, the curve at `s` may be closer to the far side of a small ball than to the side that was hit.
    V nearest_on_curve(V s, const MaskOf<V>& lanes, const Vec3<V>& chord_point, const Vec3<V>& piece) const {
        const DeferredEvents<V, Events>& d = deferred;
        MaskOf<V> open = lanes;
        for (int i = 0; i < 3 && any(open); ++i) {
            const V next = s - dot(d.curve.at(s) - chord_point, piece) / dot(d.curve.slope(s), piece), last = s;
            s = select(open & is_finite(next), min(max(next, d.lo), d.hi), s);
            open = open & (abs(s - last) > V(newton_tolerance) * (d.hi - d.lo));
        }
        return s;
    }

    /// Runs Newton's method on the dense output of the piece that was hit. If the ends of the piece lie on opposite
    /// sides of the surface, the iterates stay between the last positions before and behind the surface.
    void refine_on_curve(const MaskOf<V>& smooth) {
        DeferredEvents<V, Events>& d = deferred;
        const V length = d.hi - d.lo, margin = V(S(0.25)) * length, half(S(0.5)), slack = V(S(1.0 / 16)) * length;
        const V least = max(d.lo - margin, V(least_fraction)), greatest = d.hi + margin;
        const V side = d.level_set.value(d.curve.at(d.lo));
        const MaskOf<V> crossing = smooth & (side * d.level_set.value(d.curve.at(d.hi)) < V(S(0)));
        V s = d.guess, before = d.lo, behind = d.hi;
        MaskOf<V> open = smooth;
        for (int i = 0; i < max_corrections && any(open); ++i) {
            const Vec3<V> q = d.curve.at(s);
            const V value = d.level_set.value(q);
            const V next = s + d.level_set.intersect_line(q, d.curve.slope(s), decreasing_).length;
            const MaskOf<V> before_surface = side * value > V(S(0));
            before = select(before_surface, s, before);
            behind = select(before_surface, behind, s);
            const V middle = half * (before + behind),
                    bracketed = select((next >= before - slack) & (next <= behind + slack), next, middle);
            const V unbracketed = select(is_finite(next), min(max(next, least), greatest), s), last = s;
            s = select(open, select(crossing, bracketed, unbracketed), s);
            // Without a bracket, the number of iterations is limited to three.
            open = open & (abs(s - last) > V(newton_tolerance) * length);
            if (i >= 2) open = open & crossing;
        }
        const MaskOf<V> inside = (s > least) & (s < greatest);
        unrefined = to_bits(smooth & !inside);
        d.guess = select(smooth & inside, s, d.guess);
    }

    /// Takes a partial step to the estimated position and corrects its end by Newton's method. On a sphere, the
    /// corrections approach the side that was hit. The partial step may end beyond the surface, because dense output is
    /// less accurate along the ray than across it. Each correction squares the error. After a correction below about
    /// the square root of the rounding unit, the remaining segment is straight to rounding, and `extrapolate` adds it.
    /// A converged lane no longer changes, so that its result does not depend on other lanes.
    ///
    /// The first correction is a fraction of order h³ of the step. Its extrapolation has an error of order h⁵ in the
    /// momentum, which is within the error of a method of order five. A symplectic method would lose about
    /// 1e-8 of its conserved quantities. In double precision it therefore always takes the correction step.
    void refine_by_level_set(const MaskOf<V>& mask, const MaskOf<V>& by_value, const V& full_length) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V zero(S(0)), rounding = V(S(4)) * position_rounding(full_length),
                limit = max(V(S(0.25) * std::sqrt(machine_epsilon<S>)), rounding), first_limit = limit_of_first(limit);
        const MaskOf<V> all = mask & !by_value;
        MaskOf<V> moving = all, open = all & !from_bits<V>(unrefined);
        StepEnd<V> refined = step;
        step.h = select(by_value, zero, d.guess * full_length);
        if (!task_.resumes) task_.begin(step);
        for (int i = 0; i < max_corrections; ++i) {
            if (i == 0) task_.step(step);
            else task_.correction_step(step);
            refined.copy_lanes(step, moving);
            const auto [remaining, misses] = d.level_set.intersect_line(step.end.q(), step.end.velocity, decreasing_);
            const V s = max(min(d.guess + remaining / full_length, V(greatest_fraction)), V(least_fraction));
            MaskOf<V> usable = step.solved & is_finite(remaining) & is_finite(sum_of_momenta(step.end));
            if (i >= 2) usable = usable & !misses;  // the tangent of a ray may miss a surface that is far away
            if (step.options.test_energy) lost_energy_ |= to_bits(open & usable & !step.energy_is_conserved);
            unreached |= to_bits(open & !usable) | lost_energy_;
            open = open & usable & !from_bits<V>(lost_energy_);
            const MaskOf<V> converged = open & !misses & (abs(s - d.guess) <= (i > 0 ? limit : first_limit));
            if (any(converged)) extrapolate(refined, (s - d.guess) * full_length, converged);
            d.guess = select(converged, s, d.guess);
            open = open & !converged;
            if (!any(open)) break;
            task_.begin_next(step, mask);
            moving = open;
            step.h = select(open, (s - d.guess) * full_length, zero);
            d.guess = select(open, s, d.guess);
        }
        unreached |= to_bits(open);
        static_cast<StepEnd<V>&>(step).copy_lanes(refined, mask);
    }
    /// Returns the greatest first correction, as a fraction of the step, that is extrapolated.
    V limit_of_first(const V& limit) const {
        const IntegratorInfo& method = task_.method.info;
        if (method.order <= 5 && !method.symplectic && !task_.straight) return max(V(S(1e-3)), limit);
        return std::is_same_v<S, float> ? limit : V(S(0));
    }
    /// Returns a number that is finite if the momentum is finite.
    static V sum_of_momenta(const State<V>& state) {
        const Vec3<V> p = state.p();
        return p.x + p.y + p.z;
    }
    /// Returns the rounding error of the position, as a fraction of the step.
    V position_rounding(const V& full_length) const {
        const Vec3<V> q = deferred.step.end.q(), &v = whole.start.velocity;
        const V far = max(max(abs(q.x), abs(q.y)), abs(q.z)), speed = max(max(abs(v.x), abs(v.y)), abs(v.z));
        const V rounding = V(machine_epsilon<S>) * far / (speed * abs(full_length));
        return select(is_finite(rounding), rounding, V(S(0)));
    }

    /// Extrapolates rays by a small parameter length beyond the last step. Positions are extrapolated with the velocity
    /// at the end and its mean rate of change in the step, other quantities with their mean rates in the step. For the
    /// latter, the length is limited to one step length, because a longer one would magnify rounding errors.
    void extrapolate(StepEnd<V>& refined, const V& length, const MaskOf<V>& lanes) {
        const StepperState<V>& step = deferred.step;
        const V one(S(1)), zero(S(0)), h = select(lanes, length, zero);
        const V ratio = select(lanes & (abs(step.h) > zero), max(min(h / step.h, one), -one), zero);
        const Vec3<V> mean = advance(step.end.velocity, V(S(0.5)) * ratio, step.end.velocity - step.start.velocity);
        const Vec3<V> q = advance(refined.end.q(), h, mean);
        const V offset = deferred.level_set.value(q) / deferred.level_set.slope(q, step.end.velocity),
                h_to_surface = select(lanes & is_finite(offset), h - offset, h);
        const auto extrapolate_value = [&](const V& from, const V& to, V& end) { end = fma(ratio, to - from, end); };
        refined.end.set(advance(refined.end.q(), h_to_surface, mean), refined.end.p());
        for (int k = 0; k < space_size; ++k)
            extrapolate_value(step.start.y[momentum(k)], step.end.y[momentum(k)], refined.end.y[momentum(k)]);
        extrapolate_value(step.start.velocity.x, step.end.velocity.x, refined.end.velocity.x);
        extrapolate_value(step.start.velocity.y, step.end.velocity.y, refined.end.velocity.y);
        extrapolate_value(step.start.velocity.z, step.end.velocity.z, refined.end.velocity.z);
        extrapolate_value(step.start.parameter, step.end.parameter, refined.end.parameter);
    }

    /// Finds the zero of each lane's value by the secant method. Every trial step begins at the start of the step,
    /// because the state beyond the event may be undefined. When the secant moves by less than `margin`, the next trial
    /// moves by `margin`, so that two close trials enclose the event. If they do not, the step is discontinuous at the
    /// event. Lanes outside `lanes` keep their end.
    void refine_by_value(const MaskOf<V>& lanes, const V& full_length) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V resolution(S(16) * machine_epsilon<S>), zero(S(0));
        MaskOf<V> open = lanes;
        V last_s(zero), last_value = value_at(step.start), before(zero), after = select(lanes, d.hi, V(S(1))),
                        margin = resolution;
        for (int i = 0; i < max_corrections; ++i) {
            // `begin` is called in every iteration, so that a lane does not depend on the iterations of other lanes.
            if (!task_.resumes) task_.begin(step);
            step.h = select(lanes, d.guess * full_length, zero);
            const V gradients = step.gradients;
            task_.step(step);
            step.gradients = select(open, step.gradients, gradients);
            const V value = value_at(step.end), secant = d.guess - value * (d.guess - last_s) / (value - last_value);
            before = select(value > zero, d.guess, before);
            after = select(value > zero, after, d.guess);
            const MaskOf<V> stalled = abs(secant - d.guess) < margin;
            const V trial = select(stalled, d.guess + select(value > zero, margin, -margin), secant);
            margin = select(stalled, V(S(4)) * margin, margin);  // rounding may reverse the sign of a value
            const V next = select((trial > before) & (trial <= after), trial, V(S(0.5)) * (before + after));
            last_s = d.guess;
            last_value = value;
            const MaskOf<V> usable = is_finite(next) & is_finite(sum_of_momenta(step.end));
            unreached |= to_bits(open & !usable);
            open = open & usable & (after - before > V(S(2)) * margin);
            if (!any(open)) break;
            if (i + 1 == max_corrections) unreached |= to_bits(open & (after - before > V(max_gap) * resolution));
            else d.guess = select(open, next, d.guess);
        }
        if (step.options.test_energy) unreached |= to_bits(lanes & !(step.solved & step.energy_is_conserved));
        end_at_whole_step();
        task_.begin_next(step, lanes);
    }
    /// Moves unreached rays of events with `ends_if_unrefined` to the end of their whole step.
    void end_at_whole_step() {
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) {
                if (!Event::ends_if_unrefined) return;
                const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & unreached;
                static_cast<StepEnd<V>&>(deferred.step).copy_lanes(whole, from_bits<V>(lanes));
                unreached &= ~lanes;
            }
        });
    }

    /// Keeps the chord's hit in those of `lanes` whose curve passes the surface within `grazing_tolerance`. A chord may
    /// hit a surface that the curve just misses.
    void keep_grazing_hits(std::uint64_t lanes, const V& estimate, const Vec3<V>& chord_point, const Vec3<V>& piece) {
        if (!lanes) return;
        DeferredEvents<V, Events>& d = deferred;
        const Vec3<V> chord = whole.end.q() - whole.start.q();
        const V closest = nearest_on_curve(estimate, from_bits<V>(lanes), chord_point, piece),
                distance = d.level_set.value(d.curve.at(closest)), tolerance(grazing_tolerance);
        const std::uint64_t grazing = lanes & to_bits(distance * distance <= tolerance * tolerance * dot(chord, chord));
        const MaskOf<V> mask = from_bits<V>(grazing);
        d.guess = select(mask, closest, d.guess);
        interpolate(mask);
        d.step.end.set(select<V>(mask, chord_point, d.step.end.q()), d.step.end.p());
        unrefined |= grazing;
        unreached &= ~grazing;
    }

    /// Moves the rays of `mask` to the fraction `guess` of the chord of the whole step.
    void interpolate(const MaskOf<V>& mask) {
        const V& s = deferred.guess;
        RayState<V>& end = deferred.step.end;
        const Vec3<V> chord = whole.end.q() - whole.start.q();
        for (int k = 0; k < phase_size; ++k)
            end.y[k] = select(mask, fma(s, whole.end.y[k] - whole.start.y[k], whole.start.y[k]), end.y[k]);
        end.parameter =
            select(mask, fma(s, whole.end.parameter - whole.start.parameter, whole.start.parameter), end.parameter);
        end.velocity = select<V>(mask, chord, end.velocity);
    }

    static constexpr int max_corrections = 30;  ///< Greatest number of iterations of a refinement method.
    /// Newton's method on dense output stops when it moves by less than this fraction of the piece.
    static constexpr S newton_tolerance = S(1e-3);
    /// Greatest distance of a ray on a sphere from the sphere, as a fraction of the radius.
    static constexpr S sphere_tolerance = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
    /// A step is discontinuous if trials around an event stay farther apart than this multiple of `resolution`.
    static constexpr S max_gap = 1024;
    /// Greatest distance of a grazing curve from the surface that its chord hits, as a fraction of the step's chord.
    static constexpr S grazing_tolerance = S(0.01);
    /// Range of the search for an event, as fractions of its step. Events before the start belong to the previous step.
    static constexpr S least_fraction = S(-1e-3), greatest_fraction = S(1.25);

    const Task<V>& task_;
    MaskOf<V> decreasing_;           ///< Lanes that approach their level set from its positive side.
    std::uint64_t lost_energy_ = 0;  ///< Lanes whose partial step did not conserve H.
};

}  // namespace kagero
