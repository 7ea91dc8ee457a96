/// Fast path for straight rays: their end on the first surface or on the escape sphere follows in closed form from one
/// query, without any step.
#pragma once

#include "kernels/events/event_detector.h"
#include "kernels/trace/path_integrals.h"
#include "kernels/trace/ray_end_writer.h"
#include "kernels/trace/step_length.h"

#include <algorithm>

namespace kagero {

/// Ends the active rays of a packet whose straight line leaves the escape sphere. Other rays remain active: they start
/// outside the sphere and pass it, or their state is not finite. `scene` is null if the scene has no surfaces.
template <class V>
void end_straight_rays(const Task<V>& task, Packet<V>& packet, SceneIntersector<V>* scene, RayEndWriter<V>& writer,
                       const PathIntegrals<V>& integrals, Counters& counters) {
    using S = ScalarOf<V>;
    StepperState<V>& state = packet.state;
    const V exit_length = straight_exit_length(task, state.start);
    const Vec3<V> from = state.start.q(), v = state.start.velocity, to = advance(from, exit_length, v);
    const std::uint64_t leaving =
        packet.active & to_bits(has_left_scene(task, to, v) & is_finite(sum_of_all(state.start, v)));
    std::uint64_t hits = scene ? scene->intersect_straight(from, to, leaving) : 0;
    V fraction(S(0));
    if (hits) {
        writer.set_surfaces(scene->hits().surface, scene->hits().primitive);
        fraction = chord_fraction(scene->chords().level_sets(hits), from, to, scene->hits().t);
        // A start on a named surface may lie within rounding behind the surface that the ray hits.
        const MaskOf<V> is_behind = (fraction < V(S(0))) & !from_bits<V>(scene->hits().departing);
        hits &= ~to_bits(is_outside(task, advance(from, fraction, to - from)) | is_behind);
    }
    if (hits != leaving)
        fraction = select(from_bits<V>(hits), fraction,
                          chord_fraction(EscapeSphere::level_set(task), from, to, V(S(1))));
    state.end.set(advance(from, fraction, to - from), state.start.p());
    state.end.velocity = v;
    state.end.parameter = fraction * exit_length;
    if (integrals.requested) {
        state.h = state.end.parameter;
        integrals.add_step(state, from_bits<V>(leaving), packet.integrals);
    }
    packet.steps = select(from_bits<V>(leaving), V(S(1)), packet.steps);
    counters.issued_lane_steps += Packet<V>::W;
    counters.active_lane_steps += static_cast<std::uint64_t>(__builtin_popcountll(leaving));
    writer.end_rays(state, hits, SurfaceHit::status);
    writer.end_rays(state, leaving & ~hits, EscapeSphere::status);
    packet.active &= ~leaving;
}

}  // namespace kagero
