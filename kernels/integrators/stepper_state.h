/// Ray states, the step between two ray states, and the memory of steppers.
#pragma once

#include "kernels/integrators/coefficients.h"
#include "kernels/equations/system.h"
#include "kernels/simd/lanes.h"

namespace kagero {

/// Number of values per ray that a stepper may store from step to step.
inline constexpr int stepper_memory_size = 8;

/// Greatest permitted |K| at the end of a step, relative to the square root of squared_energy_terms. If |K| is
/// greater, the end of the step lies on a different ray.
template <class S>
inline constexpr S max_energy_error = S(0.03);

/// The n carried quantities besides λ. The specialisation for n = 0 is empty, so that it occupies no memory.
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
    V parameter;                                             ///< λ, the first carried quantity
    [[no_unique_address]] FurtherCarried<V, N - 1> further;  ///< carried quantities besides λ
    V carried_rounding[N] = {};                              ///< rounding errors of the carried quantities
    V squared_energy_terms;                                  ///< EventFunctions::squared_energy_terms
    V domain;                                                ///< ≤ 0 where the ray has left the medium
    V captured;                                              ///< ≤ 0 where the ray is captured
    V switching;        ///< switching function; changes sign where H or its derivatives jump
    V max_step_length;  ///< greatest permitted |h dq/dτ| of a step h that starts in this state
    /// Memory of the stepper. Gauss methods store the rounding error of the state; orbit methods store L, u, du/dφ and
    /// a tangential vector (OrbitMemory). Before `begin` of an orbit method, the memory contains the rounding errors of
    /// position and momentum.
    V stepper_memory[stepper_memory_size] = {};

    /// Returns carried quantity k; λ is the first.
    KAGERO_INLINE const V& carried(int k) const {
        if constexpr (N == 1) return parameter;
        else return k == 0 ? parameter : further.value[k - 1];
    }
    KAGERO_INLINE V& carried(int k) { return const_cast<V&>(static_cast<const RayState&>(*this).carried(k)); }

    /// Calls function(x, y) for each number x of the state a and the corresponding number y of the state b.
    template <class Function>
    KAGERO_INLINE static void for_each_number(RayState& a, const RayState& b, const Function& function) {
        for_each_motion_number(a, b, function);
        function(a.squared_energy_terms, b.squared_energy_terms);
        function(a.domain, b.domain);
        function(a.captured, b.captured);
        function(a.switching, b.switching);
        function(a.max_step_length, b.max_step_length);
        for (int k = 0; k < stepper_memory_size; ++k) function(a.stepper_memory[k], b.stepper_memory[k]);
    }
    /// Calls function(x, y) only for position, momentum, velocity and carried quantities.
    template <class Function>
    KAGERO_INLINE static void for_each_motion_number(RayState& a, const RayState& b, const Function& function) {
        for (int k = 0; k < state_size; ++k) function(a.y[k], b.y[k]);
        function(a.velocity.x, b.velocity.x);
        function(a.velocity.y, b.velocity.y);
        function(a.velocity.z, b.velocity.z);
        for (int k = 0; k < N; ++k) {
            function(a.carried(k), b.carried(k));
            function(a.carried_rounding[k], b.carried_rounding[k]);
        }
    }
};

/// Function object that copies the lanes of a mask from one value to another.
template <class V>
struct CopyLanes {
    const MaskOf<V>& lanes;
    KAGERO_INLINE void operator()(V& to, const V& from) const { to = select(lanes, from, to); }
};

/// The end of a step: the ray state, H there, and the number of gradient evaluations since the start of the ray.
template <class V, int N = default_carried>
struct StepEnd {
    RayState<V, N> end;
    V energy_error;  ///< |H − H0| / (|p·∂H/∂p| + |H0|) at the end
    V energy;        ///< H at the end
    V gradients;     ///< number of gradient evaluations of each ray, accumulated over its steps

    /// Copies the given lanes of `from`, except the event functions and the stepper's memory.
    void copy_lanes(const StepEnd& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::for_each_motion_number(end, from.end, copy);
        copy(energy_error, from.energy_error);
        copy(energy, from.energy);
        copy(gradients, from.gradients);
    }
};

/// Options of a step: the data that are computed, and the tolerances. Most members are copies of members of Job.
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
    ScalarOf<V> tolerance{};  ///< permitted local error of adaptive methods (RungeKutta::control)
    ScalarOf<V> position_scale = 1, momentum_scale = 1, value_weight = 1;  ///< see Job::tolerance
};

/// A step: its start, length and end.
template <class V, int N = default_carried>
struct Step : StepEnd<V, N> {
    // Set by the tracing loop, for the next call of the stepper.
    RayState<V, N> start;
    V h;  ///< step length in τ, or in radians for orbit methods; 0 in inactive lanes, whose state then does not change
    StepOptions<V> options;
    std::uint64_t ingoing = 0;  ///< lanes whose states are in ingoing coordinates (kernels/observers/charts.h)

    // Set by the stepper, in addition to `end`.
    MaskOf<V> energy_is_conserved;  ///< lanes in which H at the end is finite and still close to H0
    MaskOf<V> solved;               ///< lanes in which the implicit equations were solved
    MaskOf<V> accepted;             ///< adaptive methods: lanes in which the local error is within the tolerance
    V suggested_length;             ///< adaptive methods: length of the next step, or of the repeated step

    // Iterations of implicit solves, accumulated over the steps.
    V lane_iterations;                    ///< for each lane, number of iterations until the lane converged
    std::uint64_t issued_iterations = 0;  ///< number of iterations until all lanes of the packet converged

    /// Copies start, length and end of the step in the given lanes of `from`.
    void copy_lanes(const Step& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        RayState<V, N>::for_each_number(this->end, from.end, copy);
        RayState<V, N>::for_each_number(start, from.start, copy);
        copy(h, from.h);
        copy(this->energy_error, from.energy_error);
        copy(this->energy, from.energy);
        copy(this->gradients, from.gradients);
    }
};

/// A step with the derivatives that the stepper keeps for the next step. `begin` of the stepper initialises them.
template <class V, int N = default_carried>
struct StepperState : Step<V, N> {
    /// Gauss methods: derivatives at the stages of the previous step. Other steppers store vectors (`stage_vector`).
    PhaseGradient<V> stage[max_stages];

    /// Returns the vector in the first three components of stage[i]. Compositions store ∂K/∂q (i = 0) and ∂K/∂p (i = 1)
    /// at the end of a step. Orbit methods store dq/dφ (i = 0) for `finish`.
    KAGERO_INLINE Vec3<V> stage_vector(int i) const { return {stage[i][0], stage[i][1], stage[i][2]}; }
    KAGERO_INLINE void set_stage_vector(int i, const Vec3<V>& vector) {
        stage[i][0] = vector.x;
        stage[i][1] = vector.y;
        stage[i][2] = vector.z;
    }
};

/// Integration of rays to the escape sphere without event detection, for rays that cannot meet a surface.
template <class V>
struct EscapeIntegration {
    V h;                      ///< requested step length; 0 in inactive lanes
    double radius;            ///< radius of the escape sphere
    std::uint32_t max_steps;  ///< the number of steps of each ray stays below this limit
    bool ends_captured;       ///< captured rays end; otherwise the tracing loop continues them
    // Set by the stepper.
    MaskOf<V> arrived;                    ///< lanes whose final state lies on the escape sphere
    MaskOf<V> captured;                   ///< lanes whose ray ends: it is captured by the step after the final state
    V steps;                              ///< number of steps of each ray
    std::uint64_t issued_steps = 0;       ///< number of steps of the packet
    std::uint64_t active_lane_steps = 0;  ///< sum of the numbers of steps of the rays of the packet
};

}  // namespace kagero
