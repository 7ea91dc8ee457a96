/// The rest of the tracing loop: what is written of a ray when it ends, and after each of its steps.
#pragma once

#include "kernels/tracing/loop.h"

namespace kagero {

/// Writes the end of a ray from the end of the step in `f`.
template <class V>
void PacketTracer<V>::retire(const Flow<V>& f, int lane, Status status, Failure failure) {
    RayEnd& e = *ends_[lane];
    e = {};
    for (int k = 0; k < 3; ++k) e.q[k] = double(get_lane(f.end.y[k], lane)), e.p[k] = double(get_lane(f.end.y[3 + k], lane));
    const Vec3<double> v{double(get_lane(f.end_velocity.x, lane)), double(get_lane(f.end_velocity.y, lane)),
                         double(get_lane(f.end_velocity.z, lane))};
    const double speed = norm(v), inverse = speed > 0 && std::isfinite(speed) ? 1 / speed : 0;
    e.v[0] = v.x * inverse, e.v[1] = v.y * inverse, e.v[2] = v.z * inverse;
    e.pt = double(get_lane(f.start.y[6], lane));
    e.parameter = double(get_lane(f.end_parameter, lane));
    e.energy_error = double(get_lane(worst_energy_, lane));
    e.steps = static_cast<std::uint32_t>(get_lane(steps_, lane));
    e.gradients = static_cast<std::uint32_t>(get_lane(f.gradients, lane));
    e.status = status, e.failure = failure;
    counters_.steps += e.steps, counters_.gradients += e.gradients;
    if (job_.path_sink && e.steps > 0) report_path(f, std::uint64_t(1) << lane, false);
}

template <class V>
void PacketTracer<V>::report_path(const Flow<V>& f, std::uint64_t lanes, bool at_start) {
    if (!job_.path_sink) return;
    const State<V>& state = at_start ? f.start : f.end;
    const Vec3<V>& velocity = at_start ? f.start_velocity : f.end_velocity;
    for (std::uint64_t rest = lanes; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        PathPoint point{};
        point.ray = numbers_[i], point.step = at_start ? 0 : static_cast<std::uint32_t>(get_lane(steps_, i));
        point.parameter = double(get_lane(at_start ? f.start_parameter : f.end_parameter, i));
        for (int k = 0; k < 3; ++k) point.q[k] = double(get_lane(state.y[k], i)), point.p[k] = double(get_lane(state.y[3 + k], i));
        const Vec3<double> v{double(get_lane(velocity.x, i)), double(get_lane(velocity.y, i)), double(get_lane(velocity.z, i))};
        const double inverse = 1 / norm(v);
        point.v[0] = v.x * inverse, point.v[1] = v.y * inverse, point.v[2] = v.z * inverse;
        point.pt = double(get_lane(f.start.y[6], i)), point.energy = double(get_lane(f.energy, i));
        job_.path_sink(job_.path_user, &point);
    }
}

}  // namespace kagero
