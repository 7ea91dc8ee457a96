/// Tests a step for all events and defers the refinement of events within the step.
#pragma once

#include "kernels/events/deferred_events.h"
#include "kernels/events/scene_intersector.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// The events that were detected in one step of a packet.
template <class Events>
struct Detected {
    /// Lanes whose step is too curved to be intersected with the scene; the step must be repeated with half its length.
    std::uint64_t too_curved = 0;
    std::uint64_t within = 0;        ///< Lanes with an event within the step; the event has been deferred.
    std::uint64_t at_end = 0;        ///< Lanes with an event at the end of the step.
    LanesOfEvents<Events> lanes_of;  ///< The lanes of `within` and `at_end` by type of event.
    /// Returns the lanes with an event; they become inactive after this step.
    std::uint64_t stopped() const { return within | at_end; }
};

/// Detects the events of a packet, step by step.
template <class V, class Events = AllEvents>
class EventDetector {
    using S = ScalarOf<V>;

public:
    explicit EventDetector(const Task<V>& task) : task_(task) {
        if (SurfaceHit::exists(task)) scene_.emplace(task);
    }
    /// Returns the intersector of the scene, or nullptr if the scene has no surfaces.
    const SceneIntersector<V>* scene() const { return scene_ ? &*scene_ : nullptr; }
    SceneIntersector<V>* scene() { return scene_ ? &*scene_ : nullptr; }

    /// Initializes the detection for new rays in `lanes`. The rays of `on_surface` start on the given surfaces.
    void begin(std::uint64_t lanes, std::uint64_t on_surface, const std::uint32_t* surface,
               const std::uint32_t* primitive) {
        if (scene_) scene_->chords().begin(lanes, on_surface, surface, primitive);
    }
    /// Called where rays of `lanes` continue from an event: they are no longer at their start.
    void leave_start(std::uint64_t lanes) {
        if (scene_) scene_->chords().starts().forget(lanes);
    }
    /// Ignores a surface on which the next step of `lanes` starts. Called if this step starts at the start of a ray, or
    /// at an event that has changed the state of the ray.
    void ignore_surface_at_start(std::uint64_t lanes) {
        if (scene_) scene_->chords().ignore_surface_at_start(lanes);
    }
    /// Ignores the deferred primitives in the next query of `lanes`, whose rays have passed them without a hit.
    void ignore_passed(std::uint64_t lanes, DeferredEvents<V, Events>& deferred) {
        if (!scene_) return;
        for (const int i : lanes_in(lanes))
            if (deferred.passed.count[i] == 0) deferred.passed.add(i, deferred.surface[i], deferred.primitive[i]);
        scene_->chords().ignore_passed(lanes, deferred.passed);
    }
    /// Records which rays of `lanes` move away from the origin at `start`, where their next step begins.
    void start_steps(const RayState<V>& start, std::uint64_t lanes) {
        const std::uint64_t outward = to_bits(dot(start.q(), start.velocity) > V(S(0)));
        outward_ = (outward_ & ~lanes) | (outward & lanes);
    }

    /// Tests the steps of the lanes `moving` for all events. `steps` is the number of steps of each ray, including this
    /// one. Adds events within the step to `deferred`.
    Detected<Events> detect(const StepperState<V>& step, std::uint64_t moving, const V& steps,
                            DeferredEvents<V, Events>& deferred) {
        Detected<Events> found;
        const std::uint64_t outward = to_bits(dot(step.end.q(), step.end.velocity) > V(S(0)));
        Excursion<V> excursion;
        std::uint64_t excursions = moving & outward_ & ~outward;
        if (excursions) excursions = find_excursions(task_, step, excursions, excursion);
        // `intersect` removes lanes whose step is too curved from `tested`.
        std::uint64_t tested = moving, hits = scene_ ? scene_->intersect(step, tested) : 0;
        if (tested != moving) {
            found.too_curved = moving & ~tested;
            moving = tested;
            excursions &= moving;
        }
        if (hits | excursions | lanes_with_possible_event(step, moving, steps)) {
            if (excursions & hits) hits &= ~(excursions & to_bits(excursion.exit < scene_->hits().hit_fraction()));
            if (hits) hits = defer_hits(step, hits, deferred, found);
            if (excursions &= ~hits) defer_excursions(excursion, excursions, deferred, found);
            find_crossed(step, steps, moving & ~(hits | excursions), deferred, found);
            if (found.within) deferred.store_steps(task_, step, found.within);
        }
        const std::uint64_t continuing = moving & ~found.stopped();
        outward_ = (outward_ & ~continuing) | (outward & continuing);
        return found;
    }

private:
    /// Returns the lanes of `moving` for which the quick test of at least one event succeeds.
    KAGERO_INLINE std::uint64_t lanes_with_possible_event(const Step<V>& step, std::uint64_t moving,
                                                          const V& steps) const {
        MaskOf<V> possible = no_lanes<V>();
        Events::each([&]<class Event>() __attribute__((always_inline)) {
            if constexpr (requires { Event::possible(task_, step, steps); })
                if (Event::exists(task_)) possible = possible | Event::possible(task_, step, steps);
        });
        return moving & to_bits(possible);
    }
    /// Assigns to each lane of `open` the first event of the list that its step has crossed, and defers the event if it
    /// lies within the step. The lanes `open` have no event yet.
    void find_crossed(const Step<V>& step, const V& steps, std::uint64_t open, DeferredEvents<V, Events>& deferred,
                      Detected<Events>& found) const {
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::possible(task_, step, steps); }) {
                if (!open || !Event::exists(task_)) return;
                const std::uint64_t lanes = open & to_bits(crossed<Event>(step, steps));
                if (!lanes) return;
                found.lanes_of.template of<Event>() |= lanes;
                open &= ~lanes;
                if constexpr (HasValue<Event, V> || HasLevelSet<Event, V>) {
                    deferred.template defer_before<Event>(task_, lanes, step.start, step.end, V(S(1)));
                    found.within |= lanes;
                } else {
                    found.at_end |= lanes;
                }
            }
        });
    }
    /// Returns the lanes whose step has crossed the event.
    template <class Event>
    MaskOf<V> crossed(const Step<V>& step, const V& steps) const {
        if constexpr (requires { Event::crossed(task_, step); }) return Event::crossed(task_, step);
        else return Event::possible(task_, step, steps);
    }

    /// Defers the hits of `lanes`, except hits beyond an escape sphere, and those of rays that leave the chart sphere
    /// before. Returns the lanes whose hits were deferred.
    std::uint64_t defer_hits(const StepperState<V>& step, std::uint64_t lanes, DeferredEvents<V, Events>& deferred,
                             Detected<Events>& found) const {
        const SurfaceHits<V>& hits = scene_->hits();
        const Curve<V> curve = task_.curve(step);
        const Vec3<V> a = curve.at(hits.piece_start), b = curve.at(hits.piece_end);
        const Vec3<V> hit = advance(a, hits.t, b - a);
        lanes &= ~to_bits(is_outside(task_, hit));
        if (ChartSphere::exists(task_))
            lanes &= ~(step.ingoing & to_bits(dot(hit, hit) >= ChartSphere::squared_radius(task_)));
        if (!lanes) return 0;
        const LevelSet<V> level_sets = scene_->chords().level_sets(lanes);
        const V fraction = chord_fraction(level_sets, a, b, hits.t);
        deferred.template defer<SurfaceHit>(lanes, level_sets, hits.piece_start, hits.piece_end,
                                            fma(hits.piece_end - hits.piece_start, fraction, hits.piece_start));
        for (const int i : lanes_in(lanes)) {
            KAGERO_ASSERT(hits.surface[i] < task_.job.geometry->surface_count);
            deferred.surface[i] = hits.surface[i];
            deferred.primitive[i] = hits.primitive[i];
            deferred.passed.count[i] = 0;
        }
        const SurfaceStarts<V>& starts = scene_->chords().starts();
        deferred.inside = (deferred.inside & ~lanes) | starts.inside(lanes, hits.surface);
        deferred.departing &= ~lanes;
        for (const int i : lanes_in(lanes & hits.departing)) {
            deferred.departing |= std::uint64_t(1) << i;
            deferred.start_surface[i] = starts.surface(i);
            deferred.start_primitive[i] = starts.primitive(i);
        }
        found.lanes_of.template of<SurfaceHit>() |= lanes;
        found.within |= lanes;
        return lanes;
    }
    /// Defers the escapes of `lanes`, which leave the escape sphere and return within their step.
    void defer_excursions(const Excursion<V>& excursion, std::uint64_t lanes, DeferredEvents<V, Events>& deferred,
                          Detected<Events>& found) const {
        deferred.template defer<EscapeSphere>(lanes, EscapeSphere::level_set(task_), V(S(0)), excursion.farthest,
                                              excursion.exit);
        found.lanes_of.template of<EscapeSphere>() |= lanes;
        found.within |= lanes;
    }

    const Task<V>& task_;
    std::optional<SceneIntersector<V>> scene_;
    std::uint64_t outward_ = 0;  ///< Lanes whose ray moves away from the origin at the start of its step.
};

}  // namespace kagero
