/// Rounding bounds from recorded ray paths: the implementation of `Module::bound_roundings`.
#pragma once

#include "kernels/adjoint/sweep.h"
#include "kernels/methods/task.h"
#include "kernels/trace/trace_entry.h"

#include <algorithm>

namespace kagero {

/// A packet of ray paths, one per lane. Lanes without a path repeat the path of lane 0.
template <class V>
class PathPacket {
    static constexpr std::uint32_t W = lane_count<V>;

public:
    /// Takes the first W of `count` paths, or all of them if there are fewer.
    PathPacket(const RayPath* paths, std::uint32_t count) : path_count_(std::min(count, W)) {
        for (std::uint32_t i = 0; i < W; ++i) {
            paths_[i] = i < path_count_ ? &paths[i] : paths;
            max_points_ = std::max(max_points_, paths_[i]->count);
        }
    }
    /// Returns the number of lanes with a path of their own.
    std::uint32_t path_count() const { return path_count_; }
    /// Returns the number of points of the longest path.
    std::uint32_t max_points() const { return max_points_; }

    /// Returns the normals of the surfaces on which the rays end, and the derivatives of the ends' film coordinates.
    EndSensitivity<V> end_sensitivity() const {
        EndSensitivity<V> e;
        for (std::uint32_t i = 0; i < W; ++i) {
            set_vector(e.normal, i, paths_[i]->normal);
            for (int r = 0; r < 2; ++r) {
                set_vector(e.by_position[r], i, paths_[i]->by_position[r]);
                set_vector(e.by_direction[r], i, paths_[i]->by_direction[r]);
            }
        }
        return e;
    }
    /// Returns the states k points before the last points of the paths, and sets `parameter` to λ at these points. If a
    /// path has at most k points, its lane contains the state at the start of the path.
    State<V> before_end(std::uint32_t k, V& parameter) const {
        State<V> state;
        for (std::uint32_t i = 0; i < W; ++i) {
            const PathPoint& point = paths_[i]->points[paths_[i]->count - 1 - std::min(k, paths_[i]->count - 1)];
            for (int c = 0; c < space_size; ++c) {
                set_lane(state.y[c], int(i), point.q[c]);
                set_lane(state.y[momentum(c)], int(i), point.p[c]);
            }
            set_lane(state.pt(), int(i), point.pt);
            set_lane(parameter, int(i), point.parameter);
        }
        return state;
    }

private:
    /// Sets a lane of the vector v to x.
    static void set_vector(Vec3<V>& v, std::uint32_t lane, const double (&x)[3]) {
        set_lane(v.x, int(lane), x[0]);
        set_lane(v.y, int(lane), x[1]);
        set_lane(v.z, int(lane), x[2]);
    }

    std::uint32_t path_count_, max_points_ = 0;
    const RayPath* paths_[W];
};

/// Writes, for each path, a bound in pixels on the effect of rounding errors on the film position of its end.
/// `unit_roundoff` is half a unit in the last place of 1 in the number type of the rays.
template <class V>
void bound_roundings(const Job* job, const RayPath* paths, std::uint32_t count, double unit_roundoff, double* pixels) {
    const SpaceKernel<V>& kernel = space_of<V>(*job);
    const RoundingCounts counts = rounding_counts_of(methods[job->integrator]);
    SystemStorage system;
    kernel.construct(system, job->parameters);
    const SweptSystem<V> swept_system{kernel, system};
    for (std::uint32_t first = 0; first < count; first += lane_count<V>) {
        const PathPacket<V> packet(paths + first, count - first);
        V end_parameter, start_parameter;  // λ at the end and at the start of a step
        Sweep<V> sweep;
        sweep.state = packet.before_end(0, end_parameter);
        begin_sweep(swept_system, packet.end_sensitivity(), sweep);
        for (std::uint32_t k = 1; k < packet.max_points(); ++k) {
            const State<V> step_start = packet.before_end(k, start_parameter);
            sweep_step(swept_system, step_start, end_parameter - start_parameter, counts, sweep);
            end_parameter = start_parameter;
        }
        for (std::uint32_t i = 0; i < packet.path_count(); ++i)
            pixels[first + i] = unit_roundoff * get_lane(sweep.bound, int(i));
    }
}

}  // namespace kagero
