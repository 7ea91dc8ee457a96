#include "rays/start_rays.h"

#include "media/regions.h"
#include "scene/vector3.h"
#include "spaces/charts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace kagero {
namespace {

/// Returns the maximum |q| at which H is evaluated. Its square is well within the range of the kernel's number type.
double max_distance(const Plan& plan) { return plan.run.kernel->precision == Precision::float32 ? 1e18 : 1e150; }

/// Starts of rays with dq/dλ along given directions. What rays with the same position share is computed once, as long
/// as they follow each other.
class DirectedStarts {
public:
    explicit DirectedStarts(const Plan& plan)
        : plan_(plan), scene_(*plan.scene), max_distance_(max_distance(plan)), hole_(scene_.space.hole()) {}

    /// Returns the start of a ray at q with dq/dλ along d. A ray that moves outward from a point beyond the escape
    /// radius and beyond max_distance escapes at its start. Its momentum is computed at the distance max_distance in
    /// direction q.
    RayStart along(const double (&q)[3], const Double3& d) {
        // −0 differs from 0.
        if (!is_prepared_ || std::memcmp(q, position_, sizeof position_) != 0) move_to(q);
        const bool outward = unit_[0] * d[0] + unit_[1] * d[1] + unit_[2] * d[2] > 0;
        const bool far = is_far_ && outward;
        // The prepared position is far away and serves only rays that move outward.
        RayStart start = is_far_ && !outward ? scene_.space.start(q, d) : scene_.space.start(prepared_, d);
        start.escaped = far && start.failure == Failure::none;
        std::copy(q, q + 3, start.q);
        if (start.failure == Failure::none && ingoing_) plan_.module().to_ingoing(&hole_, &start);
        return start;
    }

private:
    void move_to(const double (&q)[3]) {
        const double distance = std::hypot(q[0], q[1], q[2]);
        is_far_ = distance > max_distance_ && distance > scene_.limits.escape_radius && std::isfinite(distance);
        const double shrink = is_far_ ? max_distance_ / distance : 1;
        for (int i = 0; i < 3; ++i) unit_[i] = q[i] / distance;
        prepared_ = scene_.space.prepare_starts({shrink * q[0], shrink * q[1], shrink * q[2]});
        ingoing_ = starts_ingoing(scene_.space, scene_.limits.chart_radius, std::nullopt, q);
        std::copy(q, q + 3, position_);
        is_prepared_ = true;
    }

    const Plan& plan_;
    const Scene& scene_;
    const double max_distance_;
    const Hole hole_;
    bool is_prepared_ = false;
    double position_[3] = {};
    double unit_[3] = {};       ///< Unit vector along the position.
    StartPosition prepared_{};  ///< The position, or a closer one if it is far away.
    bool is_far_ = false;       ///< Rays that move outward escape at their start.
    bool ingoing_ = false;      ///< Rays start in ingoing coordinates.
};

/// Rest frame of an observer that can be moved. The frame is computed again only if the position changes.
class ObserverFrame {
public:
    ObserverFrame(const Plan& plan, ObserverKind observer) : kind(observer), plan_(plan) {}

    /// Moves the observer to q. Returns Failure::none, or the reason why the observer has no rest frame at q.
    Failure move_to(const double (&q)[3]) {
        if (!std::equal(q, q + 3, position_)) {
            failure_ = make_observer_map(*plan_.scene, kind, q, map);
            std::copy(q, q + 3, position_);
        }
        return failure_;
    }

    const ObserverKind kind;
    StartMap map;  ///< Map from directions to momenta at the observer's position.

private:
    static constexpr double unset = std::numeric_limits<double>::quiet_NaN();
    const Plan& plan_;
    double position_[3] = {unset, unset, unset};
    Failure failure_ = Failure::none;
};

/// Returns the start of a ray whose direction d is given in the rest frame of an observer.
RayStart start_in_frame(const Plan& plan, ObserverFrame& frame, const double (&q)[3], Double3 d) {
    RayStart start{{q[0], q[1], q[2]}, {0, 0, 0}, 0, Failure::none, false, false};
    const double greatest_component = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    if (!std::isfinite(q[0] + q[1] + q[2]) || !std::isfinite(d[0]) || !std::isfinite(d[1]) || !std::isfinite(d[2]))
        return start.failure = Failure::nonfinite_start, start;
    if (!(greatest_component > 0)) return start.failure = Failure::zero_direction, start;
    for (double& component : d) component /= greatest_component;  // avoids overflow; the length of d has no effect
    start.failure = frame.move_to(q);
    if (start.failure == Failure::no_rest_frame) return plan.scene->space.start(q, d);
    return start.failure == Failure::none ? ray_in_frame(frame.map, d).start : start;
}

/// Returns the reason why a ray that has a momentum cannot be traced; `none` if it can.
Failure start_failure(const Plan& plan, const RayStart& start, bool is_falling) {
    const Scene& scene = *plan.scene;
    if ((start.failure == Failure::none || start.failure == Failure::singular_start) && !start.escaped &&
        std::hypot(start.q[0], start.q[1], start.q[2]) > max_distance(plan))
        return Failure::too_far;
    if (start.failure != Failure::none) return start.failure;
    if (has_invalid_time_rescaling(scene, start.q)) return Failure::bad_time_rescaling;
    if (has_invalid_bounds(scene, start.q)) return Failure::invalid_bounds;
    const bool has_frequency = !start.captured && !is_falling && start.pt > 0;  // p_t is a divisor
    if (has_frequency && plan.run.kernel->precision == Precision::float32 &&
        needs_double(scene, std::hypot(start.p[0], start.p[1], start.p[2]) / std::abs(start.pt)))
        return Failure::needs_double;
    return Failure::none;
}

/// Returns the medium in which a ray starts. A ray that starts on a boundary is in the medium into which it moves.
std::uint32_t medium_of(const Scene& scene, const RayInput& ray) {
    if (!scene.regions) return 0;
    const Double3 q = subtract(scaled(ray.position, 1 / scene.unit), scene.description.space.center);
    const double size = length(ray.direction);
    if (!std::isfinite(dot(q, q))) return 0;
    if (!(size > 0 && std::isfinite(size))) return scene.regions->medium_at(q);
    return scene.regions->medium_ahead(q, scaled(ray.direction, 1 / size));
}

}  // namespace

void write_starts(const Plan& plan, const RayArrays& rays, std::optional<ObserverKind> observer, std::size_t first,
                  std::size_t last, RayStart* starts) {
    std::vector<std::optional<ObserverFrame>> frames(plan.media.size() + 1);
    std::vector<std::optional<DirectedStarts>> directed(plan.media.size() + 1);
    for (std::size_t i = first; i < last; ++i) {
        const RayInput ray = rays[i];
        const std::uint32_t medium = medium_of(*plan.scene, ray);
        const Plan& around = plan.medium(medium);
        std::optional<ObserverFrame>& frame = frames[medium];
        if (observer && !frame) frame.emplace(around, *observer);
        if (!observer && !directed[medium]) directed[medium].emplace(around);
        double q[3];
        for (std::size_t k = 0; k < 3; ++k)
            q[k] = ray.position[k] / around.scene->unit - around.description().space.center[k];
        RayStart start =
            frame ? start_in_frame(around, *frame, q, ray.direction) : directed[medium]->along(q, ray.direction);
        start.failure = start_failure(around, start, observer == ObserverKind::falling);
        start.medium = medium;
        starts[i - first] = start;
    }
}

std::vector<RayStart> start_rays(const Plan& plan, const std::vector<RayInput>& rays,
                                 std::optional<ObserverKind> observer) {
    std::vector<RayStart> starts(rays.size());
    if (rays.empty()) return starts;
    constexpr std::size_t stride = sizeof(RayInput) / sizeof(double);
    const RayArrays arrays{rays[0].position.data(), rays[0].direction.data(), rays.size(), stride, stride};
    write_starts(plan, arrays, observer, 0, rays.size(), starts.data());
    return starts;
}

}  // namespace kagero
