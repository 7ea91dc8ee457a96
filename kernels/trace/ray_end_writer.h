/// Writes ray ends and the points of paths. Every ray of a packet ends in one call of this class, with one status.
#pragma once

#include "kernels/events/scene_intersector.h"
#include "kernels/trace/end_columns.h"
#include "kernels/observers/charts.h"
#include "kernels/trace/packet.h"

#include <limits>

namespace kagero {

/// Writes the ray ends of one packet.
template <class V>
class RayEndWriter {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    RayEndWriter(const Task<V>& task, Packet<V>& packet, Counters& counters)
        : job_(task.job), packet_(packet), counters_(counters), active_before_(counters.active_lane_steps),
          issued_before_(counters.issued_lane_steps) {}

    /// Ends the rays of `lanes` at the end of `step`. A ray whose state is not finite has failed, except that the state
    /// of a captured ray need not be finite.
    void end_rays(const StepperState<V>& step, std::uint64_t lanes, Status status, Failure failure = Failure::none) {
        if (!lanes) return;
        const bool may_be_nonfinite = status == Status::failed || status == Status::captured;
        const std::uint64_t finite =
            may_be_nonfinite ? lanes : lanes & to_bits(is_finite(sum_of_all(step.end, step.end.velocity)));
        write(step, finite, status, failure);
        write(step, lanes & ~finite, Status::failed, Failure::not_finite);
    }
    /// Ends the rays of `lanes` as failed, at the end of their last accepted step. The reason is `not_converged` in
    /// lanes of `unsolved`, `energy_lost` in lanes of `not_conserved`, else `not_finite`.
    void fail_rays(std::uint64_t lanes, std::uint64_t unsolved, std::uint64_t not_conserved) {
        fail_at_step_start(lanes & unsolved, Failure::not_converged);
        fail_at_step_start(lanes & not_conserved & ~unsolved, Failure::energy_lost);
        fail_at_step_start(lanes & ~(unsolved | not_conserved), Failure::not_finite);
    }
    /// Ends the rays of `lanes` as failed, at the end of their last accepted step.
    void fail_at_step_start(std::uint64_t lanes, Failure failure) {
        if (!lanes) return;
        StepperState<V> last = packet_.state;
        last.end = last.start;
        end_rays(last, lanes, Status::failed, failure);
        packet_.deactivate(lanes);
    }
    /// Ends the rays of `lanes` as failed at their start. Their energy error is NaN.
    void fail_at_start(std::uint64_t lanes, Failure failure) {
        end_rays(packet_.state, lanes, Status::failed, failure);
        for (const int i : lanes_in(lanes)) packet_.ends[i]->energy_error = std::numeric_limits<double>::quiet_NaN();
    }
    /// Ends a ray that starts beyond the escape sphere as escaped. It may start so far away that the number type of the
    /// packet cannot represent it, so its end is copied from the double-precision start.
    void end_far_away(const RayStarts<W>& starts, int lane) {
        write(packet_.state, std::uint64_t(1) << lane, Status::escaped, Failure::none);
        RayEnd& e = *packet_.ends[lane];
        const auto y = [&](int k) { return starts.y[k][lane]; };
        const double inverse = 1 / norm(Vec3<double>{y(component_px), y(component_py), y(component_pz)});
        for (int k = 0; k < space_size; ++k) {
            e.q[k] = y(k);
            e.p[k] = y(momentum(k));
            e.v[k] = y(momentum(k)) * inverse;
        }
        e.pt = y(component_pt);
        e.parameter = e.energy_error = e.action = e.time = 0;
    }
    /// Sets the surfaces and primitives of the hits that are written next.
    void set_surfaces(const std::uint32_t (&surface)[W], const std::uint32_t (&primitive)[W]) {
        surface_ = &surface;
        primitive_ = &primitive;
    }
    /// Sets the intersector whose query counts are written; nullptr if the scene has no surfaces.
    void set_scene(const SceneIntersector<V>* scene) { scene_ = scene; }

    /// Overwrites the iteration counts of ray ends. Used for rays with a deferred event, because lane_iterations of
    /// their lanes has increased since the event was deferred.
    void write_iterations(std::uint64_t lanes, const V& iterations) {
        for (const int i : lanes_in(lanes)) {
            std::uint32_t& iterations_of_ray = packet_.ends[i]->iterations;
            counters_.active_iterations -= iterations_of_ray;
            iterations_of_ray = static_cast<std::uint32_t>(get_lane(iterations, i));
            counters_.active_iterations += iterations_of_ray;
        }
    }
    /// Marks the ends of `lanes` as `unrefined`.
    void write_unrefined(std::uint64_t lanes) {
        for (const int i : lanes_in(lanes)) {
            packet_.ends[i]->unrefined = true;
            ++counters_.unrefined;
        }
    }
    /// Overwrites the occupancy in the ends of `lanes`, whose rays have ended before the last ray of the packet.
    void write_occupancy(std::uint64_t lanes) {
        const float occupancy = occupancy_so_far();
        for (const int i : lanes_in(lanes)) packet_.ends[i]->occupancy = occupancy;
    }
    /// Reports the start of `step` (if `at_start`) or its end as the next point of the paths of `lanes`. With
    /// Job::path_interval, only the start is reported; PathRecorder reports the other points.
    void report_path(const StepperState<V>& step, std::uint64_t lanes, bool at_start) {
        if (job_.path_interval > 0 && !at_start) return;
        const auto number_of = [&](int i) { return std::uint32_t(at_start ? 0 : get_lane(packet_.steps, i)); };
        report_points(step, at_start ? step.start : step.end, packet_.integrals, lanes, number_of);
    }
    /// Reports the points `state` of the paths of `lanes`. number_of(i) returns PathPoint::step of lane i.
    template <class NumberOf>
    void report_points(const StepperState<V>& step, const RayState<V>& state, const PathSums<V>& integrals,
                       std::uint64_t lanes, const NumberOf& number_of) {
        for (const int i : lanes_in(lanes)) {
            PathPoint point{};
            point.ray = packet_.ray_indices[i];
            point.step = number_of(i);
            point.parameter = double(get_lane(state.parameter, i));
            for (int k = 0; k < space_size; ++k) {
                point.q[k] = double(get_lane(state.y[k], i));
                point.p[k] = double(get_lane(state.y[momentum(k)], i));
            }
            const Vec3<double> v = lane_of(state.velocity, i);
            const double inverse = 1 / norm(v);
            point.v[0] = v.x * inverse;
            point.v[1] = v.y * inverse;
            point.v[2] = v.z * inverse;
            point.pt = double(get_lane(step.start.pt(), i));
            point.energy = double(get_lane(step.energy, i));
            if (job_.outputs & output_integrals) {
                point.action = integrals.of_lane(0, i);
                point.time = integrals.of_lane(1, i);
            }
            if ((packet_.state.ingoing >> i) & 1) to_scene_chart(point, i);
            if ((packet_.from_inside >> i) & 1) keep_ingoing_integrals(point, i);
            job_.path_sink(job_.path_user, &point);
        }
    }

private:
    /// Writes the ray ends of `lanes` and updates the counters of the call.
    void write(const StepperState<V>& step, std::uint64_t lanes, Status status, Failure failure) {
        if (!lanes) return;
        KAGERO_ASSERT((lanes & ~packet_.filled) == 0);
        KAGERO_ASSERT((status == Status::failed) == (failure != Failure::none));
        RayEnd common{};
        common.occupancy = occupancy_so_far();
        common.status = status;
        common.failure = failure;
        EndColumns<V> ends(common);
        ends.set(offsetof(RayEnd, q), step.end.q());
        ends.set(offsetof(RayEnd, p), step.end.p());
        ends.set(offsetof(RayEnd, v), direction_of(step.end.velocity));
        ends.set(offsetof(RayEnd, pt), step.start.pt());
        ends.set(offsetof(RayEnd, parameter), step.end.parameter);
        ends.set(offsetof(RayEnd, energy_error), packet_.worst_energy_error);
        counters_.steps += ends.set_counts(offsetof(RayEnd, steps), packet_.steps, lanes);
        counters_.gradients += ends.set_counts(offsetof(RayEnd, gradients), step.gradients, lanes);
        if (scene_) counters_.queries += ends.set_counts(offsetof(RayEnd, queries), scene_->chords().queries(), lanes);
        if (status == Status::hit) {
            ends.set_words(offsetof(RayEnd, surface), *surface_);
            ends.set_words(offsetof(RayEnd, primitive), *primitive_);
        }
        ends.write(lanes, packet_.ends);
        if (job_.outputs & output_integrals) write_integrals(lanes);
        for (const int i : lanes_in(lanes & packet_.state.ingoing)) to_scene_chart(*packet_.ends[i], i);
        for (const int i : lanes_in(lanes & packet_.from_inside)) keep_ingoing_integrals(*packet_.ends[i], i);
        counters_.ended[static_cast<int>(status)] += static_cast<std::uint64_t>(__builtin_popcountll(lanes));
        if (packet_.state.issued_iterations > 0) write_iterations(lanes, packet_.state.lane_iterations);
        // The end of a failed ray is the end of its last accepted step, which has been reported already.
        if (job_.path_sink && status != Status::failed)
            report_path(step, lanes & to_bits(packet_.steps > V(S(0))), false);
    }
    /// Converts a ray end or a point of a path from the kernel's ingoing coordinates to the coordinates of the scene.
    template <class Point>
    void to_scene_chart(Point& point, int lane) const {
        const Hole& hole = hole_of(job_, lane);
        charts::State state;
        std::copy_n(point.q, space_size, state.q);
        std::copy_n(point.p, space_size, state.p);
        std::copy_n(point.v, space_size, state.v);
        state.pt = point.pt;
        if ((job_.outputs & output_integrals) && !((packet_.from_inside >> lane) & 1))
            charts::integrals_to_outgoing(hole, charts::radius(hole, state.q), -state.pt, point.action, point.time);
        charts::to_scene(hole, state);
        std::copy_n(state.q, space_size, point.q);
        std::copy_n(state.p, space_size, point.p);
        std::copy_n(state.v, space_size, point.v);
        point.pt = state.pt;
    }
    /// Converts the integrals of a ray that started inside the horizon and is now in outgoing coordinates to those of
    /// the ingoing form: the time of the outgoing form is infinite on the horizon.
    template <class Point>
    void keep_ingoing_integrals(Point& point, int lane) const {
        if ((packet_.state.ingoing >> lane) & 1) return;
        if (!(job_.outputs & output_integrals)) return;
        const Hole& hole = hole_of(job_, lane);
        charts::integrals_to_ingoing(hole, charts::radius(hole, point.q), point.pt, point.action, point.time);
    }
    /// Writes the integrals along the rays of `lanes`.
    __attribute__((noinline)) void write_integrals(std::uint64_t lanes) {
        for (const int i : lanes_in(lanes)) {
            packet_.ends[i]->action = packet_.integrals.of_lane(0, i);
            packet_.ends[i]->time = packet_.integrals.of_lane(1, i);
        }
    }
    /// Returns unit vectors along v. The square of v may overflow, so v is scaled first.
    static Vec3<V> direction_of(const Vec3<V>& v) {
        const V largest = max(greatest_component(v), V(std::numeric_limits<S>::min()));
        const Vec3<V> scaled = total_recip(largest) * v;
        const V inverse = rsqrt(dot(scaled, scaled));
        return select(is_finite(inverse), inverse, V(S(0))) * scaled;
    }
    /// Returns the occupancy of the packet since its start.
    float occupancy_so_far() const {
        const std::uint64_t issued = counters_.issued_lane_steps - issued_before_;
        return issued > 0 ? float(double(counters_.active_lane_steps - active_before_) / double(issued)) : 0;
    }

    const Job& job_;
    Packet<V>& packet_;
    Counters& counters_;
    const SceneIntersector<V>* scene_ = nullptr;
    const std::uint32_t (*surface_)[W] = nullptr, (*primitive_)[W] = nullptr;
    const std::uint64_t active_before_, issued_before_;  ///< Lane-steps of the call before the packet started.
};

}  // namespace kagero
