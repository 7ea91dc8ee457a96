#include "rays/start_rays.h"

#include "error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kagero {
namespace {

/// Squares of lengths beyond this leave the numbers of the kernel.
double greatest_length(const Plan& plan) {
    return plan.run.kernel->precision == Precision::float32 ? 1e18 : 1e150;
}

/// The state of a ray with dq/dλ along d. Rays that start farther out than H can be evaluated, and move on outward,
/// have escaped.
RayStart directed(const Plan& plan, const double (&q)[3], const Double3& d) {
    const double distance = std::hypot(q[0], q[1], q[2]), limit = greatest_length(plan);
    const bool outward = q[0] / distance * d[0] + q[1] / distance * d[1] + q[2] / distance * d[2] > 0;
    const bool far =
        distance > limit && distance > plan.scene->limits.escape_radius && outward && std::isfinite(distance);
    const double shrink = far ? limit / distance : 1;
    const double near[3] = {shrink * q[0], shrink * q[1], shrink * q[2]};
    RayStart start = plan.scene->space.start(near, d);
    start.escaped = far && start.failure == Failure::none;
    std::copy(q, q + 3, start.q);
    return start;
}

/// The rest frame of an observer; asked for anew only where the place is another.
class ObserverFrame {
public:
    ObserverFrame(const Plan& plan, ObserverKind of) : kind(of), plan_(plan) {}

    Failure go_to(const double (&q)[3]) {
        if (!std::equal(q, q + 3, place_)) {
            failure_ = observe(*plan_.scene, kind, q, map);
            std::copy(q, q + 3, place_);
        }
        return failure_;
    }

    const ObserverKind kind;
    StartMap map;  ///< of the place gone to last

private:
    static constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();
    const Plan& plan_;
    double place_[3] = {nowhere, nowhere, nowhere};
    Failure failure_ = Failure::none;
};

/// Whether the space is another one where time runs the other way.
bool spins(const Plan& plan) {
    const HamiltonianInfo& info = plan.scene->space.info();
    for (std::uint32_t i = 0; i < info.parameter_count; ++i)
        if (info.parameters[i].odd && plan.scene->space.parameters[i] != 0) return true;
    return false;
}

/// The state of a ray whose direction is read in an observer's rest frame.
RayStart observed(const Plan& plan, ObserverFrame& frame, const double (&q)[3], Double3 d) {
    RayStart start{{q[0], q[1], q[2]}, {0, 0, 0}, 0, Failure::none, false, false};
    const double size = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    if (!std::isfinite(q[0] + q[1] + q[2]) || !std::isfinite(d[0]) || !std::isfinite(d[1]) || !std::isfinite(d[2]))
        return start.failure = Failure::nonfinite_start, start;
    if (!(size > 0)) return start.failure = Failure::zero_direction, start;
    for (double& component : d) component /= size;  // its length does not matter, however large or small
    start.failure = frame.go_to(q);
    if (start.failure == Failure::no_rest_frame) return plan.scene->space.start(q, d);
    return start.failure == Failure::none ? ray_in_frame(frame.map, q, d).start : start;
}

}  // namespace

std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays,
                                 std::optional<ObserverKind> observer) {
    const Scene& scene = *plan.scene;
    const bool is_falling = observer == ObserverKind::falling,
               in_float = plan.run.kernel->precision == Precision::float32;
    std::vector<RayStart> starts;
    starts.reserve(rays.size());
    std::optional<ObserverFrame> frame;
    if (observer) frame.emplace(plan, *observer);
    if (is_falling && scene.space.time > 0 && spins(plan))
        throw RunError("the plan was not made for rays of a falling observer (Options::observer)");
    for (const RayInput& ray : rays) {
        double q[3];
        for (int k = 0; k < 3; ++k) q[k] = ray.position[k] / scene.unit - scene.description.space.center[k];
        starts.push_back(frame ? observed(plan, *frame, q, ray.direction) : directed(plan, q, ray.direction));
    }
    for (RayStart& start : starts)
        if ((start.failure == Failure::none || start.failure == Failure::singular_start) && !start.escaped &&
            std::hypot(start.q[0], start.q[1], start.q[2]) > greatest_length(plan)) start.failure = Failure::too_far;
        else if (start.failure == Failure::none && lacks_pace(scene, start.q)) start.failure = Failure::no_pace;
        else if (start.failure == Failure::none && lacks_bounds(scene, start.q)) start.failure = Failure::no_bounds;
        else if (start.failure == Failure::none && !start.captured && !is_falling &&
                 start.pt > 0 &&  // which may vanish
                 in_float && needs_double(scene, std::hypot(start.p[0], start.p[1], start.p[2]) / std::abs(start.pt)))
            start.failure = Failure::needs_double;
    return starts;
}

}  // namespace kagero
