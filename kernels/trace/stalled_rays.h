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

    /// Resets the counters of `lanes` for new rays.
    void begin(std::uint64_t lanes) {
        for (const int i : lanes_in(lanes)) short_steps_[i] = 0;
        counted_ &= ~lanes;
    }
    /// Returns those of `lanes` in which |p| exceeds `share` of Job::max_momentum while the step changes |q| very
    /// little. `state` is the start or the end of the step. Without the second condition, rays would fail that enter
    /// the second sheet of a wormhole in inverted coordinates, where |p| grows as |q| shrinks. Around a spinning hole,
    /// a ray that approaches the horizon winds up, so that its step can be long although |q| hardly changes.
    std::uint64_t with_diverging_momentum(const Step<V>& step, const State<V>& state, double share,
                                          std::uint64_t lanes) const {
        const Vec3<V> p = state.p(), q = state.q();
        const V radial_length = abs(step.h * dot(step.start.q(), step.start.velocity));  // times |q|
        const MaskOf<V> is_large = dot(p, p) > V(S(share * share * max_square_)),
                        is_short = radial_length < V(S(short_share)) * dot(q, q);
        return lanes & to_bits(is_large & is_short);
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
    /// Length of a step, relative to |q|, below which a large momentum diverges.
    static constexpr double short_share = 1e-3;
    /// Number of short steps in a row that a ray may take, for example near a point where H is not smooth.
    static constexpr std::uint8_t max_short_steps = 64;

    const double max_square_, min_square_;
    std::uint64_t counted_ = 0;  ///< Lanes whose last step was short.
    std::uint8_t short_steps_[W] = {};
};

}  // namespace kagero
