/// States of rays, the step that they take, and what a stepper remembers.
#pragma once

#include "kernels/integrators/coefficients.h"
#include "kernels/equations/system.h"
#include "kernels/simd/lanes.h"

namespace kagero {

/// How many numbers a stepper may remember from step to step.
inline constexpr int stepper_memory = 8;

/// The quantities that a ray carries beside λ; where there are none they take no room.
template <class V, int n>
struct FurtherCarried {
    V value[n];
};
template <class V>
struct FurtherCarried<V, 0> {};

/// The state of a ray between two steps, and all that the next step needs. The ray carries N quantities beside its
/// state.
template <class V, int N = default_carried>
struct RayState : State<V> {
    Vec3<V> velocity;    ///< dq/dτ
    V parameter;         ///< λ of H: the first quantity that it carries along
    [[no_unique_address]] FurtherCarried<V, N - 1> further;  ///< the other ones, of which the system states the rates
    V energy_terms;      ///< EventFunctions::terms
    V domain;            ///< ≤ 0 where the ray has left the medium
    V captured;          ///< ≤ 0 where the ray is captured
    V switching;              ///< changes sign where H is not smooth
    V max_step_length;             ///< no step from here may be longer
    /// The memory of the stepper: what rounding has cut off the state (Gauss, and where an orbit starts), or the orbit.
    V carry[stepper_memory] = {};

    /// Quantity k that it carries along; λ is the first.
    KAGERO_INLINE const V& carried(int k) const {
        if constexpr (N == 1) return parameter;
        else return k == 0 ? parameter : further.value[k - 1];
    }
    KAGERO_INLINE V& carried(int k) { return const_cast<V&>(static_cast<const RayState&>(*this).carried(k)); }

    /// Calls a function with every number of two states; `each_of_motion` with those of position, direction and carried
    /// quantities.
    template <class Function>
    KAGERO_INLINE static void each(RayState& a, const RayState& b, const Function& function) {
        each_of_motion(a, b, function);
        function(a.energy_terms, b.energy_terms), function(a.domain, b.domain), function(a.captured, b.captured);
        function(a.switching, b.switching), function(a.max_step_length, b.max_step_length);
        for (int k = 0; k < stepper_memory; ++k) function(a.carry[k], b.carry[k]);
    }
    template <class Function>
    KAGERO_INLINE static void each_of_motion(RayState& a, const RayState& b, const Function& function) {
        for (int k = 0; k < state_size; ++k) function(a.y[k], b.y[k]);
        function(a.velocity.x, b.velocity.x), function(a.velocity.y, b.velocity.y),
            function(a.velocity.z, b.velocity.z);
        for (int k = 0; k < N; ++k) function(a.carried(k), b.carried(k));
    }
};

/// Copies the lanes of `lanes`.
template <class V>
struct CopyLanes {
    const MaskOf<V>& lanes;
    KAGERO_INLINE void operator()(V& to, const V& from) const { to = select(lanes, from, to); }
};

/// The end of a step.
template <class V, int N = default_carried>
struct StepEnd {
    RayState<V, N> end;
    V energy_error;  ///< |H − H0| / (|p·∂H/∂p| + |H0|) at the end
    V energy;        ///< H at the end
    V gradients;     ///< derivative evaluations of each ray, accumulated

    /// The lanes of `from` that `lanes` selects.
    void take(const StepEnd& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::each_of_motion(end, from.end, copy);
        copy(energy_error, from.energy_error), copy(energy, from.energy), copy(gradients, from.gradients);
    }
};

/// What a step has to compute, and how exactly. Most of these are those of the job.
template <class V>
struct StepOptions {
    bool want_carried = false;  ///< λ and the further quantities that rays carry along
    bool want_energy = false;   ///< StepEnd::energy_error
    bool want_path = false;     ///< StepEnd::energy
    bool test_energy = false;   ///< Step::energy_holds
    bool use_symmetry = true;   ///< Job::use_symmetry
    ScalarOf<V> capture_within = std::numeric_limits<ScalarOf<V>>::infinity();  ///< Job::capture_within
    ScalarOf<V> capture_stretch = 1;                                            ///< Job::capture_stretch
    ScalarOf<V> solver_tolerance{};  ///< of implicit equations, relative; 0: to rounding
    ScalarOf<V> tolerance{};         ///< local error of adaptive methods, relative to 1 + |value|
};

/// A step: its start, its length and its end.
template <class V, int N = default_carried>
struct Step : StepEnd<V, N> {
    // Set by the tracing loop.
    RayState<V, N> start;
    V h;  ///< step length in the integration parameter τ; 0 in inactive lanes: their steps change nothing
    StepOptions<V> options;

    // Set by the stepper, beside the end.
    MaskOf<V> energy_holds;    ///< the step has not lost H
    MaskOf<V> solved;          ///< the implicit equations were solved
    MaskOf<V> accepted;        ///< adaptive methods: the local error is within the tolerance
    V suggested;  ///< adaptive methods: the length of the next step, or of this one if it is to be taken again

    // Iterations of implicit solves, accumulated: those that each ray needed, and those that the packet ran.
    V open_iterations;
    std::uint64_t issued_iterations = 0;

    /// The lanes of `from` that `lanes` selects.
    void take(const Step& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::each(this->end, from.end, copy), RayState<V, N>::each(start, from.start, copy);
        copy(h, from.h), copy(this->energy_error, from.energy_error), copy(this->energy, from.energy),
            copy(this->gradients, from.gradients);
    }
};

/// A step and what the stepper remembers beside it; `begin` fills that memory.
template <class V, int N = default_carried>
struct StepperState : Step<V, N> {
    /// Derivatives at the stages of the last step (Gauss), or the last forces and velocities (composition).
    PhaseGradient<V> stage[max_stages];
};

/// An integration to the escape sphere by the stepper alone, for rays that meet nothing.
template <class V>
struct EscapeIntegration {
    V h;                       ///< length of its steps; 0 in inactive lanes
    double radius;             ///< of the escape sphere
    std::uint32_t max_steps;
    // Set by the stepper.
    MaskOf<V> arrived;         ///< the end of the step lies on the sphere
    V steps;                   ///< taken by each ray
    std::uint64_t issued_steps = 0, active_lane_steps = 0;
};

}  // namespace kagero
