/// Detection of rays that would go on forever: their momentum grows, or their steps shrink, without bound. An example
/// is a ray that approaches a horizon in coordinates that are singular there. Such a ray would use up `max_steps`.
#pragma once

#include "kernels/trace/packet.h"

#include <cmath>

namespace kagero {

/// Detector for the rays of one packet.
template <class V>
class StalledRays {
    using S = ScalarOf<V>;
    static constexpr int W = lane_count<V>;

public:
    explicit StalledRays(const Job& job)
        : exist(std::isfinite(job.max_momentum) || job.min_step_length > 0),
          max_square_(job.max_momentum * job.max_momentum), min_square_(job.min_step_length * job.min_step_length) {}

    /// Resets the counters of `lanes` for new rays, which begin with `starts`.
    void begin(std::uint64_t lanes, const State<V>& starts) {
        for (const int i : lanes_in(lanes)) short_steps_[i] = 0;
        counted_ &= ~lanes;
        start_square_ = select(from_bits<V>(lanes), dot(starts.p(), starts.p()), start_square_);
    }
    /// Returns those of `lanes` in which |p| exceeds `share` of Job::max_momentum while the step changes |q| very
    /// little. `state` is the start or the end of the step. Without the second condition, rays would fail that enter
    /// the second sheet of a wormhole in inverted coordinates, where |p| grows as |q| shrinks. Around a spinning hole,
    /// a ray that approaches the horizon winds up, so that its step can be long although |q| hardly changes.
    std::uint64_t with_diverging_momentum(const Step<V>& step, const State<V>& state, double share,
                                          std::uint64_t lanes) const {
        const Vec3<V> p = state.p();
        return lanes & to_bits((dot(p, p) > V(S(share * share * max_square_))) & is_short(step, state, short_share));
    }
    /// Returns those of `lanes` whose momentum grows while their steps are rejected. The conditions are weaker than
    /// those of with_diverging_momentum, because the rejections are evidence too. A ray whose momentum is large at its
    /// start, near a horizon, and then decreases is not one of them. |p| is that at the start of the rejected step.
    std::uint64_t with_growing_momentum(const Step<V>& rejected, std::uint64_t lanes) const {
        const Vec3<V> p = rejected.start.p();
        const V square = dot(p, p);
        const MaskOf<V> has_grown = (square > V(S(growing_share * growing_share * max_square_))) &
                                    (square > V(S(least_growth * least_growth)) * start_square_);
        return lanes & to_bits(has_grown & is_short(rejected, rejected.start, short_share_of_rejected));
    }
    /// Counts the accepted steps of `lanes` that are shorter than Job::min_step_length. Returns the lanes with too many
    /// of them in a row.
    std::uint64_t with_vanishing_steps(const Step<V>& step, std::uint64_t lanes) {
        const Vec3<V> v = step.start.velocity;
        const std::uint64_t are_short = lanes & to_bits(step.h * step.h * dot(v, v) < V(S(min_square_)));
        for (const int i : lanes_in(lanes & counted_ & ~are_short)) short_steps_[i] = 0;
        counted_ = (counted_ & ~lanes) | are_short;
        std::uint64_t vanishing = 0;
        for (const int i : lanes_in(are_short))
            if (++short_steps_[i] > max_short_steps) vanishing |= std::uint64_t(1) << i;
        return vanishing;
    }

    const bool exist;  ///< False if the job sets no bounds, so that no ray can stall.

private:
    /// Returns true in the lanes whose step changes |q| by less than `share` of it.
    static MaskOf<V> is_short(const Step<V>& step, const State<V>& state, double share) {
        const Vec3<V> q = state.q();
        const V radial_length = abs(step.h * dot(step.start.q(), step.start.velocity));  // times |q|
        return radial_length < V(S(share)) * dot(q, q);
    }

    /// Length of a step, relative to |q|, below which a large momentum diverges, and the same for rejected steps.
    static constexpr double short_share = 1e-3, short_share_of_rejected = 0.15;
    /// Least momentum of a ray whose rejected steps are counted, relative to Job::max_momentum and to the momentum at
    /// the start of the ray.
    static constexpr double growing_share = 0.05, least_growth = 30;
    /// Number of short steps in a row that a ray may take, for example near a point where H is not smooth.
    static constexpr std::uint8_t max_short_steps = 64;

    const double max_square_, min_square_;
    V start_square_ = S(0);      ///< |p|² at the start of each ray.
    std::uint64_t counted_ = 0;  ///< Lanes whose last step was short.
    std::uint8_t short_steps_[W] = {};
};

}  // namespace kagero
