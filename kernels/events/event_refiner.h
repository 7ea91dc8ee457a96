/// Finds the exact positions of events and moves rays to them.
///
/// Dense output locates a surface, but its order is lower than the order of the method. The refiner therefore repeats
/// the step with the length up to the surface, and corrects the end by Newton's method with short steps of a cheap
/// method (`Task::correction_step`). Errors of position and direction at the event are of the order of the method.
#pragma once

#include "kernels/events/extrapolation.h"
#include "kernels/events/hit_confirmation.h"

#include <type_traits>

namespace kagero {

/// Refines the deferred events of one packet.
template <class V, class Events = AllEvents>
class EventRefiner {
    using S = ScalarOf<V>;

public:
    DeferredEvents<V, Events> deferred;  ///< After `refine`, deferred.step.end is the state at the event.
    Step<V> whole_step;                  ///< After `refine`, the steps on which the events were detected.
    std::uint64_t failed = 0;            ///< Lanes whose refinement failed. Shorter steps may allow refinement.
    std::uint64_t missed = 0;            ///< Lanes whose ray passes the surface that its chord has hit, and continues.
    std::uint64_t unrefined = 0;         ///< Lanes whose hit has an approximate position on the chord or dense output.

    explicit EventRefiner(const Task<V>& task) : task_(task) {}

    /// Moves all deferred rays to their events. With `hit = "chord"`, events lie on the chord of the step.
    void refine() {
        DeferredEvents<V, Events>& d = deferred;
        const MaskOf<V> mask = from_bits<V>(d.lanes);
        d.event_fraction = select(mask, d.event_fraction, V(S(0)));
        const V full_length = select(mask, d.step.h, V(S(0)));
        d.step.h = full_length;
        whole_step = d.step;
        failed = unrefined = missed = lost_energy_ = 0;
        if (on_chord()) return interpolate(mask);
        if (!task_.method_curve) d.curve = Curve<V>::hermite(d.step);
        const std::uint64_t hits = d.lanes_of.template of<SurfaceHit>();
        const HitConfirmation<V, Events> confirmation(task_);
        if (hits && d.level_set.curved) missed = confirmation.follow_grazing_rays(d, hits);
        const StepEnd<V> missed_ends = d.step;
        refine_lanes(from_bits<V>(d.lanes & ~missed), full_length, hits & ~missed);
        static_cast<StepEnd<V>&>(d.step).copy_lanes(missed_ends, from_bits<V>(missed));
        // A ray whose hit of a sphere cannot be refined may pass the sphere.
        if (const std::uint64_t unsure = hits & (failed | unrefined); unsure && d.level_set.curved) {
            const std::uint64_t passing = confirmation.follow_unsure_rays(d, whole_step, unsure);
            missed |= passing;
            failed &= ~passing;
            unrefined &= ~passing;
        }
        const std::uint64_t refined = hits & ~(failed | unrefined | missed);
        if (!refined) return;
        missed |= confirmation.confirm(d, refined, [&](std::uint64_t others) {
            const StepEnd<V> ends = d.step;
            d.step.copy_lanes(whole_step, from_bits<V>(others));
            refine_lanes(from_bits<V>(others), full_length, others);
            static_cast<StepEnd<V>&>(d.step).copy_lanes(ends, !from_bits<V>(others));
            return others & ~(failed | unrefined);
        });
    }

    /// Returns, for each event, the lanes that have crossed this event before their refined event. The position of an
    /// unrefined hit, or of an event on a chord, is not exact enough for this test.
    LanesOfEvents<Events> earlier_events() const {
        LanesOfEvents<Events> earlier;
        if (on_chord()) return earlier;
        std::uint64_t lanes = deferred.lanes & ~(failed | unrefined | lanes_without_earlier_event());
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::crossed_before(task_, whole_step.start, whole_step.end); }) {
                if (!lanes || !Event::exists(task_)) return;
                const MaskOf<V> crossed = Event::crossed_before(task_, whole_step.start, deferred.step.end);
                earlier.template of<Event>() = lanes & to_bits(crossed) & applicable_lanes<Event>(whole_step);
                lanes &= ~earlier.template of<Event>();
            }
        });
        return earlier;
    }
    /// Replaces the refined events by those of `earlier`, which lie between the start of the step and the refined one.
    void defer_again(const LanesOfEvents<Events>& earlier) {
        deferred.clear();
        const std::uint64_t lanes = earlier.lanes_with_event();
        if (!lanes) return;
        const RayState<V> beyond = deferred.step.end;
        const V fraction = deferred.event_fraction;
        deferred.step.copy_lanes(whole_step, from_bits<V>(lanes));
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::crossed_before(task_, whole_step.start, whole_step.end); })
                if (const std::uint64_t of_event = earlier.template of<Event>())
                    deferred.template defer_before<Event>(task_, of_event, whole_step.start, beyond, fraction);
        });
    }

private:
    /// Moves the rays of `mask` to their events; `hits` are the lanes with a SurfaceHit.
    void refine_lanes(const MaskOf<V>& mask, const V& full_length, std::uint64_t hits) {
        DeferredEvents<V, Events>& d = deferred;
        const Vec3<V> start = d.curve.at(d.lo), chord = d.curve.at(d.hi) - start,
                      chord_point = advance(start, (d.event_fraction - d.lo) / (d.hi - d.lo), chord);
        const V estimate = d.event_fraction;
        const std::uint64_t value_bits = lanes_with_event_value();
        const MaskOf<V> with_value = from_bits<V>(value_bits), with_level_set = mask & !with_value;
        decreasing_ = d.level_set.slope(chord_point, chord) < V(S(0));
        const MaskOf<V> spheres = with_level_set & (abs(d.level_set.a) > V(S(0)));
        // A ray that starts outside of a ball enters it; the chord may be nearly parallel to the surface.
        const MaskOf<V> starts_outside = (d.level_set.value(whole_step.start.q()) > V(S(0))) & from_bits<V>(~d.inside);
        decreasing_ = decreasing_ | (from_bits<V>(hits) & spheres & starts_outside);
        d.event_fraction = project_to_curve(estimate, spheres, chord_point, chord);
        const std::uint64_t not_on_curve = refine_on_curve(with_level_set);
        if (value_bits) refine_by_value(with_value, full_length);
        refine_by_level_set(mask, with_value, not_on_curve, full_length);
        keep_grazing_hits(failed & hits & ~lost_energy_, estimate, chord_point, chord);
        // An escape that was not found on the dense output is accepted if it lies on the escape sphere.
        const V distance = abs(d.level_set.value(d.step.end.q()));
        const MaskOf<V> on_sphere = distance <= V(sphere_tolerance) * sqrt(d.level_set.radius2);
        failed |= not_on_curve & ~hits & ~to_bits(on_sphere);
        unrefined |= not_on_curve & hits;
        fail_inward_escapes();
    }

    bool on_chord() const { return task_.job.hit == HitModel::chord; }
    /// Returns the lanes whose event is a zero of Event::value.
    std::uint64_t lanes_with_event_value() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// Returns the lanes whose event cannot follow another event on the same step.
    std::uint64_t lanes_without_earlier_event() const {
        std::uint64_t lanes = 0;
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (!Event::may_follow_another) lanes |= deferred.lanes_of.template of<Event>();
        });
        return lanes;
    }
    /// Returns Event::value of each lane's event at the state `at`; 1 if the event has no value.
    V value_at(const RayState<V>& at) const {
        V value(S(1));
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>)
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>())
                    value = select(from_bits<V>(lanes), Event::value(whole_step.start, at), value);
        });
        return value;
    }
    /// Adds the lanes to `failed` whose ray moves inward at its refined escape: it has left the sphere earlier.
    void fail_inward_escapes() {
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::moves_back(deferred.step.end); })
                if (const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & ~failed)
                    failed |= lanes & to_bits(Event::moves_back(deferred.step.end));
        });
    }

    /// Returns the fraction of the step at which the dense output crosses the plane through `chord_point` perpendicular
    /// to `chord`. The initial guess is `s`, the fraction of `chord_point`. Since the speed varies along a long step,
    /// the dense output at `s` may be closer to the exit from a small ball than to the entry that the chord has hit.
    V project_to_curve(V s, const MaskOf<V>& lanes, const Vec3<V>& chord_point, const Vec3<V>& chord) const {
        const DeferredEvents<V, Events>& d = deferred;
        MaskOf<V> open = lanes;
        for (int i = 0; i < 3 && any(open); ++i) {
            const V next = s - dot(d.curve.at(s) - chord_point, chord) / dot(d.curve.slope(s), chord), last = s;
            s = select(open & is_finite(next), min(max(next, d.lo), d.hi), s);
            open = open & (abs(s - last) > V(newton_tolerance) * (d.hi - d.lo));
        }
        return s;
    }

    /// Moves `event_fraction` of `lanes` to a point of the dense output on the level set, by Newton's method. Returns
    /// the lanes in which no such point is found. If the dense output at the fractions lo and hi of the step lies on
    /// opposite sides of the surface, the iterates stay between the last positions before and behind the surface.
    std::uint64_t refine_on_curve(const MaskOf<V>& lanes) {
        DeferredEvents<V, Events>& d = deferred;
        const V length = d.hi - d.lo, margin = V(S(0.25)) * length, half(S(0.5)), slack = V(S(1.0 / 16)) * length;
        const V least = max(d.lo - margin, V(least_fraction)), greatest = d.hi + margin;
        const V value_at_lo = d.level_set.value(d.curve.at(d.lo));
        const MaskOf<V> crossing = lanes & (value_at_lo * d.level_set.value(d.curve.at(d.hi)) < V(S(0)));
        V s = d.event_fraction, before = d.lo, behind = d.hi;
        MaskOf<V> open = lanes;
        for (int i = 0; i < max_corrections && any(open); ++i) {
            const Vec3<V> q = d.curve.at(s);
            const V value = d.level_set.value(q);
            const V next = s + d.level_set.intersect_line(q, d.curve.slope(s), decreasing_).line_parameter;
            const MaskOf<V> before_surface = value_at_lo * value > V(S(0));
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
        const MaskOf<V> in_range = (s > least) & (s < greatest);
        d.event_fraction = select(lanes & in_range, s, d.event_fraction);
        return to_bits(lanes & !in_range);
    }

    /// Takes a partial step to the estimated position and corrects its end by Newton's method. On a sphere, the
    /// corrections approach the side that was hit. The partial step may end beyond the surface, because dense output is
    /// less accurate along the ray than across it. Each correction squares the error. After a correction below about
    /// the square root of the rounding unit, the remaining segment is straight to rounding, and `extrapolate` adds it.
    /// A converged lane no longer changes, so that its result does not depend on other lanes. The first correction is a
    /// fraction of order h³ of the step. Its extrapolation has an error of order h⁵, within the error of a method of
    /// order five. For a symplectic method, extrapolation would change conserved quantities by about 1e-8.
    void refine_by_level_set(const MaskOf<V>& mask, const MaskOf<V>& with_value, std::uint64_t not_on_curve,
                             const V& full_length) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V zero(S(0)), rounding = V(S(4)) * position_rounding(whole_step, d.step.end.q(), full_length),
                limit = max(V(S(0.25) * std::sqrt(machine_epsilon<S>)), rounding), first_limit = first_limit_for(limit);
        MaskOf<V> moving = mask & !with_value, open = moving & !from_bits<V>(not_on_curve);
        StepEnd<V> refined = step;
        step.h = select(with_value, zero, d.event_fraction * full_length);
        if (!task_.steps_without_begin) task_.begin(step);
        for (int i = 0; i < max_corrections; ++i) {
            if (i == 0) task_.step(step);
            else task_.correction_step(step);
            refined.copy_lanes(step, moving);
            const auto [remaining, misses] = d.level_set.intersect_line(step.end.q(), step.end.velocity, decreasing_);
            const V s = max(min(d.event_fraction + remaining / full_length, V(greatest_fraction)), V(least_fraction));
            MaskOf<V> usable = step.solved & is_finite(remaining) & is_finite(sum_of_momenta(step.end));
            if (i >= 2) usable = usable & !misses;  // the tangent of a ray may miss a surface that is far away
            if (step.options.test_energy) lost_energy_ |= to_bits(open & usable & !step.energy_is_conserved);
            failed |= to_bits(open & !usable) | lost_energy_;
            open = open & usable & !from_bits<V>(lost_energy_);
            const V correction = s - d.event_fraction;
            const MaskOf<V> converged = open & !misses & (abs(correction) <= (i > 0 ? limit : first_limit));
            if (any(converged)) extrapolate(d.step, d.level_set, correction * full_length, converged, refined);
            d.event_fraction = select(converged, s, d.event_fraction);
            open = open & !converged;
            if (!any(open)) break;
            task_.begin_next(step, mask);
            moving = open;
            step.h = select(open, correction * full_length, zero);
            d.event_fraction = select(open, s, d.event_fraction);
        }
        failed |= to_bits(open);
        static_cast<StepEnd<V>&>(step).copy_lanes(refined, mask);
    }
    /// Returns the greatest first correction that is extrapolated, as a fraction of the step; 0: never extrapolated.
    V first_limit_for(const V& limit) const {
        const IntegratorInfo& method = task_.method.info;
        if (method.order <= 5 && !method.symplectic && !task_.straight) return max(V(S(1e-3)), limit);
        return std::is_same_v<S, float> ? limit : V(S(0));
    }
    /// Finds the zero of each lane's value by the secant method. Every trial step begins at the start of the step,
    /// because the state beyond the event may be undefined. When the secant moves by less than `margin`, the next trial
    /// moves by `margin`, so that two close trials enclose the event. If they do not, the step is discontinuous at the
    /// event. Other lanes take steps of length zero.
    void refine_by_value(const MaskOf<V>& lanes, const V& full_length) {
        DeferredEvents<V, Events>& d = deferred;
        StepperState<V>& step = d.step;
        const V resolution(S(16) * machine_epsilon<S>), zero(S(0));
        MaskOf<V> open = lanes;
        V last_s(zero), last_value = value_at(step.start), before(zero), after = select(lanes, d.hi, V(S(1))),
                        margin = resolution;
        for (int i = 0; i < max_corrections; ++i) {
            // `begin` is called in every iteration, so that a lane does not depend on the iterations of other lanes.
            if (!task_.steps_without_begin) task_.begin(step);
            step.h = select(lanes, d.event_fraction * full_length, zero);
            const V gradients = step.gradients;
            task_.step(step);
            step.gradients = select(open, step.gradients, gradients);
            const V s = d.event_fraction, value = value_at(step.end),
                    secant = s - value * (s - last_s) / (value - last_value);
            before = select(value > zero, s, before);
            after = select(value > zero, after, s);
            const MaskOf<V> stalled = abs(secant - s) < margin;
            const V trial = select(stalled, s + select(value > zero, margin, -margin), secant);
            margin = select(stalled, V(S(4)) * margin, margin);  // rounding may reverse the sign of a value
            const V next = select((trial > before) & (trial <= after), trial, V(S(0.5)) * (before + after));
            last_s = s;
            last_value = value;
            const MaskOf<V> usable = is_finite(next) & is_finite(sum_of_momenta(step.end));
            failed |= to_bits(open & !usable);
            open = open & usable & (after - before > V(S(2)) * margin);
            if (!any(open)) break;
            if (i + 1 == max_corrections) failed |= to_bits(open & (after - before > V(max_gap) * resolution));
            else d.event_fraction = select(open, next, s);
        }
        if (step.options.test_energy) failed |= to_bits(lanes & !(step.solved & step.energy_is_conserved));
        end_at_whole_step();
        task_.begin_next(step, lanes);
    }
    /// Moves rays whose refinement failed to the end of their whole step if their event has `ends_if_unrefined`.
    void end_at_whole_step() {
        Events::each([&]<class Event>() {
            if constexpr (HasValue<Event, V>) {
                if (!Event::ends_if_unrefined) return;
                const std::uint64_t lanes = deferred.lanes_of.template of<Event>() & failed;
                static_cast<StepEnd<V>&>(deferred.step).copy_lanes(whole_step, from_bits<V>(lanes));
                failed &= ~lanes;
            }
        });
    }

    /// Keeps the chord's hit in those of `lanes` whose dense output passes the surface within `grazing_tolerance`. A
    /// chord may hit a surface that the dense output just misses.
    void keep_grazing_hits(std::uint64_t lanes, const V& estimate, const Vec3<V>& chord_point, const Vec3<V>& chord) {
        if (!lanes) return;
        DeferredEvents<V, Events>& d = deferred;
        const Vec3<V> whole_chord = whole_step.end.q() - whole_step.start.q();
        const V closest = project_to_curve(estimate, from_bits<V>(lanes), chord_point, chord),
                distance = d.level_set.value(d.curve.at(closest)), tolerance(grazing_tolerance);
        const std::uint64_t grazing =
            lanes & to_bits(distance * distance <= tolerance * tolerance * dot(whole_chord, whole_chord));
        const MaskOf<V> mask = from_bits<V>(grazing);
        d.event_fraction = select(mask, closest, d.event_fraction);
        interpolate(mask);
        d.step.end.set(select<V>(mask, chord_point, d.step.end.q()), d.step.end.p());
        unrefined |= grazing;
        failed &= ~grazing;
    }

    /// Moves the rays of `mask` to `event_fraction` on the chord of the whole step; their velocity becomes the chord.
    void interpolate(const MaskOf<V>& mask) {
        const V& s = deferred.event_fraction;
        const RayState<V>&a = whole_step.start, &b = whole_step.end;
        RayState<V>& end = deferred.step.end;
        for (int k = 0; k < phase_size; ++k) end.y[k] = select(mask, fma(s, b.y[k] - a.y[k], a.y[k]), end.y[k]);
        end.parameter = select(mask, fma(s, b.parameter - a.parameter, a.parameter), end.parameter);
        end.velocity = select<V>(mask, b.q() - a.q(), end.velocity);
    }

    static constexpr int max_corrections = 30;  ///< Greatest number of iterations.
    /// Newton's method on dense output stops when it moves by less than this fraction of the length hi − lo.
    static constexpr S newton_tolerance = S(1e-3);
    /// Greatest distance from a sphere at which a ray counts as lying on it, as a fraction of the radius.
    static constexpr S sphere_tolerance = std::is_same_v<S, float> ? S(1e-5) : S(1e-10);
    /// A step is discontinuous if trials around an event stay farther apart than this multiple of `resolution`.
    static constexpr S max_gap = 1024;
    /// Greatest distance of a grazing ray from the surface that its chord hits, as a fraction of the step's chord.
    static constexpr S grazing_tolerance = S(0.01);
    /// Range of the search for an event, as fractions of its step. Events farther back belong to the previous step.
    static constexpr S least_fraction = S(-1e-3), greatest_fraction = S(1.25);

    const Task<V>& task_;
    MaskOf<V> decreasing_;           ///< Lanes in which the level-set function decreases along the ray.
    std::uint64_t lost_energy_ = 0;  ///< Lanes whose partial step did not conserve H.
};

}  // namespace kagero
