/// Tests a step for every event, and puts those within the step aside for refinement.
#pragma once

#include "kernels/events/deferred_events.h"
#include "kernels/events/scene_intersector.h"

#include <algorithm>
#include <optional>

namespace kagero {

/// What a step has led to.
template <class Events>
struct Detected {
    /// Lanes whose step bends too much to be intersected with the scene: it has to be shorter.
    std::uint64_t too_bent = 0;
    std::uint64_t within = 0;  ///< lanes with an event within the step, which has been deferred
    std::uint64_t at_end = 0;  ///< lanes with an event at the end of the step
    LanesOfEvents<Events> lanes_of;
    /// Lanes that do not go on to another step now: their ray has an event.
    std::uint64_t stopped() const { return within | at_end; }
};

template <class V, class Events = AllEvents>
class EventDetector {
    using S = ScalarOf<V>;

public:
    explicit EventDetector(const Task<V>& task) : task_(task) {
        if (SurfaceHit::exists(task)) scene_.emplace(task);
    }
    /// Null where there are no surfaces.
    const SceneIntersector<V>* scene() const { return scene_ ? &*scene_ : nullptr; }
    SceneIntersector<V>* scene() { return scene_ ? &*scene_ : nullptr; }

    /// New rays start in `lanes`.
    void begin(std::uint64_t lanes) {
        if (scene_) scene_->begin(lanes);
    }
    /// The rays of `lanes` are at their start again, or where an event lets them go on: a surface there does not count
    /// as hit.
    void return_to_start(std::uint64_t lanes) {
        if (scene_) scene_->return_to_start(lanes);
    }
    /// The steps of `lanes` begin at `start`.
    void start_steps(const RayState<V>& start, std::uint64_t lanes) {
        const std::uint64_t outward = to_bits(dot(start.q(), start.velocity) > V(S(0)));
        outward_ = (outward_ & ~lanes) | (outward & lanes);
    }

    /// Tests the step of lanes `moving`, after which they have taken `steps` steps. Events within the step go to
    /// `deferred`.
    Detected<Events> detect(const StepperState<V>& step, std::uint64_t moving, const V& steps,
                            DeferredEvents<V, Events>& deferred) {
        Detected<Events> found;
        const std::uint64_t outward = to_bits(dot(step.end.q(), step.end.velocity) > V(S(0)));
        Excursion<V> excursion;
        std::uint64_t excursions = moving & outward_ & ~outward;
        if (excursions) excursions = find_excursions(task_, step, excursions, excursion);
        std::uint64_t tested = moving, hits = scene_ ? scene_->intersect(step, tested) : 0;
        if (tested != moving) found.too_bent = moving & ~tested, moving = tested, excursions &= moving;
        if (hits | excursions | possible_events(step, moving, steps)) {
            if (excursions & hits) hits &= ~(excursions & to_bits(excursion.exit < scene_->hits.hit_fraction()));
            if (hits) hits = defer_hits(step, hits, deferred, found);
            if (excursions &= ~hits) defer_excursions(excursion, excursions, deferred, found);
            find_crossed(step, steps, moving & ~(hits | excursions), deferred, found);
            if (found.within) deferred.take(task_, step, found.within);
        }
        const std::uint64_t staying = moving & ~found.stopped();
        outward_ = (outward_ & ~staying) | (outward & staying);
        return found;
    }

private:
    /// The lanes of `moving` for which the quick test of some event succeeds.
    KAGERO_INLINE std::uint64_t possible_events(const Step<V>& step, std::uint64_t moving, const V& steps) const {
        MaskOf<V> possible = never<V>();
        Events::each([&]<class Event>() __attribute__((always_inline)) {
            if constexpr (requires { Event::possible(task_, step, steps); })
                if (Event::exists(task_)) possible = possible | Event::possible(task_, step, steps);
        });
        return moving & to_bits(possible);
    }
    /// Events that are found by the end of the step, in the order of the list.
    void find_crossed(const Step<V>& step, const V& steps, std::uint64_t open, DeferredEvents<V, Events>& deferred,
                      Detected<Events>& found) const {
        Events::each([&]<class Event>() {
            if constexpr (requires { Event::possible(task_, step, steps); }) {
                if (!open || !Event::exists(task_)) return;
                const std::uint64_t lanes = open & to_bits(crossed<Event>(step, steps));
                if (!lanes) return;
                found.lanes_of.template of<Event>() |= lanes, open &= ~lanes;
                if constexpr (HasValue<Event, V> || HasLevel<Event, V>) {
                    deferred.template defer_before<Event>(task_, lanes, step.start, step.end, V(S(1)));
                    found.within |= lanes;
                } else {
                    found.at_end |= lanes;
                }
            }
        });
    }
    template <class Event>
    MaskOf<V> crossed(const Step<V>& step, const V& steps) const {
        if constexpr (requires { Event::crossed(task_, step); }) return Event::crossed(task_, step);
        else return Event::possible(task_, step, steps);
    }

    /// Hits, except those beyond an escape sphere; returns those that count.
    std::uint64_t defer_hits(const StepperState<V>& step, std::uint64_t lanes, DeferredEvents<V, Events>& deferred,
                             Detected<Events>& found) const {
        const SurfaceHits<V>& hits = scene_->hits;
        const Curve<V> curve = task_.curve(step);
        const Vec3<V> a = curve.at(hits.from), b = curve.at(hits.to);
        lanes &= ~to_bits(is_outside(task_, advance(a, hits.t, b - a)));
        if (!lanes) return 0;
        const Level<V> levels = scene_->levels(lanes);
        const V fraction = chord_fraction(levels, a, b, hits.t);
        deferred.template defer<SurfaceHit>(lanes, levels, hits.from, hits.to,
                                            fma(hits.to - hits.from, fraction, hits.from));
        for (const int i : lanes_in(lanes)) {
            KAGERO_ASSERT(hits.surface[i] < task_.job.geometry->surface_count);
            deferred.surface[i] = hits.surface[i], deferred.primitive[i] = hits.primitive[i];
        }
        found.lanes_of.template of<SurfaceHit>() |= lanes, found.within |= lanes;
        return lanes;
    }
    void defer_excursions(const Excursion<V>& excursion, std::uint64_t lanes, DeferredEvents<V, Events>& deferred,
                          Detected<Events>& found) const {
        deferred.template defer<EscapeSphere>(lanes, EscapeSphere::level(task_), V(S(0)), excursion.farthest,
                                              excursion.exit);
        found.lanes_of.template of<EscapeSphere>() |= lanes, found.within |= lanes;
    }

    const Task<V>& task_;
    std::optional<SceneIntersector<V>> scene_;
    std::uint64_t outward_ = 0;  ///< lanes whose rays move away from the origin where their step starts
};

}  // namespace kagero
