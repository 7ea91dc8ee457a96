/// Ray states, the step between two of them, and the memory of steppers.
#pragma once

#include "kernels/integrators/coefficients.h"
#include "kernels/equations/system.h"
#include "kernels/simd/lanes.h"

namespace kagero {

/// Number of values that a stepper may store from step to step, per ray.
inline constexpr int stepper_memory_size = 8;

/// The carried quantities besides λ. The specialisation for none is empty, so it occupies no memory.
template <class V, int n>
struct FurtherCarried {
    V value[n];
};
template <class V>
struct FurtherCarried<V, 0> {};

/// The state of a ray between two steps, with all data that the next step needs. N is the number of carried quantities,
/// including λ.
template <class V, int N = default_carried>
struct RayState : State<V> {
    Vec3<V> velocity;                                        ///< dq/dτ
    V parameter;                                             ///< λ of H: the first carried quantity
    [[no_unique_address]] FurtherCarried<V, N - 1> further;  ///< carried quantities besides λ
    V energy_terms;                                          ///< EventFunctions::terms
    V domain;                                                ///< ≤ 0 where the ray has left the medium
    V captured;                                              ///< ≤ 0 where the ray is captured
    V switching;        ///< switching function; changes sign where H is not smooth
    V max_step_length;  ///< greatest permitted length of a step that starts in this state
    /// Memory of the stepper. Gauss methods store the rounding error of the state, and orbit methods store the orbit.
    /// At the start of a ray of an orbit method, it contains the rounding errors of position and momentum.
    V stepper_memory[stepper_memory_size] = {};

    /// Returns carried quantity k; λ is the first.
    KAGERO_INLINE const V& carried(int k) const {
        if constexpr (N == 1) return parameter;
        else return k == 0 ? parameter : further.value[k - 1];
    }
    KAGERO_INLINE V& carried(int k) { return const_cast<V&>(static_cast<const RayState&>(*this).carried(k)); }

    /// Calls a function with each pair of corresponding numbers of two states.
    template <class Function>
    KAGERO_INLINE static void each(RayState& a, const RayState& b, const Function& function) {
        each_of_motion(a, b, function);
        function(a.energy_terms, b.energy_terms);
        function(a.domain, b.domain);
        function(a.captured, b.captured);
        function(a.switching, b.switching);
        function(a.max_step_length, b.max_step_length);
        for (int k = 0; k < stepper_memory_size; ++k) function(a.stepper_memory[k], b.stepper_memory[k]);
    }
    /// Calls a function with each pair of numbers of position, momentum, velocity and carried quantities.
    template <class Function>
    KAGERO_INLINE static void each_of_motion(RayState& a, const RayState& b, const Function& function) {
        for (int k = 0; k < state_size; ++k) function(a.y[k], b.y[k]);
        function(a.velocity.x, b.velocity.x);
        function(a.velocity.y, b.velocity.y);
        function(a.velocity.z, b.velocity.z);
        for (int k = 0; k < N; ++k) function(a.carried(k), b.carried(k));
    }
};

/// Function object that copies the lanes of a mask.
template <class V>
struct CopyLanes {
    const MaskOf<V>& lanes;
    KAGERO_INLINE void operator()(V& to, const V& from) const { to = select(lanes, from, to); }
};

/// The end of a step: the ray state, its energy, and the number of gradients so far.
template <class V, int N = default_carried>
struct StepEnd {
    RayState<V, N> end;
    V energy_error;  ///< |H − H0| / (|p·∂H/∂p| + |H0|) at the end
    V energy;        ///< H at the end
    V gradients;     ///< number of derivative evaluations of each ray, accumulated over its steps

    /// Copies the given lanes of `from`, except the event functions and the stepper's memory.
    void copy_lanes(const StepEnd& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::each_of_motion(end, from.end, copy);
        copy(energy_error, from.energy_error);
        copy(energy, from.energy);
        copy(gradients, from.gradients);
    }
};

/// Data that a step has to compute, and its tolerances. Most members are copies of members of Job.
template <class V>
struct StepOptions {
    bool compute_carried = false;       ///< compute λ and the further carried quantities
    bool compute_energy_error = false;  ///< compute StepEnd::energy_error
    bool compute_energy = false;        ///< compute StepEnd::energy
    bool test_energy = false;           ///< reject steps that do not conserve H (Step::energy_is_conserved)
    bool use_symmetry = true;           ///< see Job::use_symmetry
    ScalarOf<V> capture_radius = std::numeric_limits<ScalarOf<V>>::infinity();  ///< see Job::capture_radius
    ScalarOf<V> capture_stretch = 1;                                            ///< see Job::capture_stretch
    ScalarOf<V> solver_tolerance{};  ///< relative tolerance of implicit equations; 0: iterate until rounding
    ScalarOf<V> tolerance{};         ///< permitted local error of adaptive methods, relative to 1 + |value|
};

/// A step: its start, length and end.
template <class V, int N = default_carried>
struct Step : StepEnd<V, N> {
    // Set by the tracing loop, for the next call of the stepper.
    RayState<V, N> start;
    V h;  ///< step length in the integration parameter τ; 0 in inactive lanes, which such a step leaves unchanged
    StepOptions<V> options;

    // Set by the stepper, together with the end.
    MaskOf<V> energy_is_conserved;  ///< lanes in which H at the end is finite and still close to H0
    MaskOf<V> solved;               ///< lanes in which the implicit equations were solved
    MaskOf<V> accepted;             ///< adaptive methods: lanes in which the local error is within the tolerance
    V suggested_length;             ///< adaptive methods: length of the next step or of the repetition

    // Iterations of implicit solves, accumulated over the steps.
    V lane_iterations;                    ///< iterations until the lane of each ray converged
    std::uint64_t issued_iterations = 0;  ///< iterations until all lanes of the packet converged

    /// Copies start, length and end of the step in the given lanes of `from`.
    void copy_lanes(const Step& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::each(this->end, from.end, copy);
        RayState<V, N>::each(start, from.start, copy);
        copy(h, from.h);
        copy(this->energy_error, from.energy_error);
        copy(this->energy, from.energy);
        copy(this->gradients, from.gradients);
    }
};

/// A step with the stage derivatives that the stepper keeps for the next step. `begin` of the stepper initialises them.
template <class V, int N = default_carried>
struct StepperState : Step<V, N> {
    /// Gauss methods: derivatives at the stages of the last step. Compositions: force and velocity at its end.
    PhaseGradient<V> stage[max_stages];
};

/// Integration of rays to the escape sphere without event detection, for rays that cannot meet a surface.
template <class V>
struct EscapeIntegration {
    V h;                      ///< step length; 0 in inactive lanes
    double radius;            ///< radius of the escape sphere
    std::uint32_t max_steps;  ///< greatest number of steps
    // Set by the stepper.
    MaskOf<V> arrived;                    ///< lanes whose final state lies on the sphere
    V steps;                              ///< number of steps of each ray
    std::uint64_t issued_steps = 0;       ///< number of steps of the packet
    std::uint64_t active_lane_steps = 0;  ///< sum of the numbers of steps of the rays
};

}  // namespace kagero
