/// The rays of one packet and the step they are taking, in memory between the tracing loop and a stepper.
#pragma once

#include "kernels/integrators/coefficients.h"
#include "kernels/equations/system.h"

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

/// Where a ray is between two steps, and all that the next step needs. The ray carries N quantities beside its state.
template <class V, int N = default_carried>
struct Waypoint : State<V> {
    Vec3<V> velocity;    ///< dq/dτ
    V parameter;         ///< λ of H: the first quantity that it carries along
    [[no_unique_address]] FurtherCarried<V, N - 1> further;  ///< the other ones, of which the system states the rates
    V energy_terms;      ///< Survey::terms
    V domain;            ///< ≤ 0 where the ray has left the medium
    V captured;          ///< ≤ 0 where the ray is captured
    V side;              ///< changes sign where H is not smooth
    V scale;             ///< no step from here may be longer
    /// The memory of the stepper: what rounding has cut off the state (Gauss, and where an orbit starts), or the orbit.
    V carry[stepper_memory] = {};

    /// Quantity k that it carries along; λ is the first.
    KAGERO_INLINE const V& carried(int k) const {
        if constexpr (N == 1) return parameter;
        else return k == 0 ? parameter : further.value[k - 1];
    }
    KAGERO_INLINE V& carried(int k) { return const_cast<V&>(static_cast<const Waypoint&>(*this).carried(k)); }

    /// Calls a function with every number of two waypoints; `each_of_motion` with those that tell where a ray is and where it goes.
    template <class Function>
    KAGERO_INLINE static void each(Waypoint& a, const Waypoint& b, const Function& function) {
        each_of_motion(a, b, function);
        function(a.energy_terms, b.energy_terms), function(a.domain, b.domain), function(a.captured, b.captured);
        function(a.side, b.side), function(a.scale, b.scale);
        for (int k = 0; k < stepper_memory; ++k) function(a.carry[k], b.carry[k]);
    }
    template <class Function>
    KAGERO_INLINE static void each_of_motion(Waypoint& a, const Waypoint& b, const Function& function) {
        for (int k = 0; k < state_size; ++k) function(a.y[k], b.y[k]);
        function(a.velocity.x, b.velocity.x), function(a.velocity.y, b.velocity.y), function(a.velocity.z, b.velocity.z);
        for (int k = 0; k < N; ++k) function(a.carried(k), b.carried(k));
    }
};

/// Copies the lanes of `lanes`.
template <class V>
struct CopyLanes {
    const MaskOf<V>& lanes;
    KAGERO_INLINE void operator()(V& to, const V& from) const { to = pick(lanes, from, to); }
};

/// What a ray takes along from a step.
template <class V, int N = default_carried>
struct Arrival {
    Waypoint<V, N> end;
    V energy_error;  ///< |H − H0| / (|p·∂H/∂p| + |H0|) at the end
    V energy;        ///< H at the end
    V gradients;     ///< derivative evaluations of each ray, accumulated

    /// The lanes of `from` that `lanes` selects.
    void take(const Arrival& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        Waypoint<V, N>::each_of_motion(end, from.end, copy);
        copy(energy_error, from.energy_error), copy(energy, from.energy), copy(gradients, from.gradients);
    }
};

/// A step, from where it begins to where it ends.
template <class V, int N = default_carried>
struct Leg : Arrival<V, N> {
    // Set by the tracing loop.
    Waypoint<V, N> start;
    V h;                       ///< step length in the integration parameter τ; 0 in finished lanes, which makes a step the identity
    bool want_carried = false;  ///< λ and the further quantities that rays carry along are wanted
    bool want_energy = false;  ///< `energy_error` is wanted
    bool want_path = false;    ///< `energy` is wanted
    bool test_energy = false;  ///< `energy_holds` is wanted
    bool use_symmetry = true;  ///< Job::use_symmetry
    ScalarOf<V> capture_within = std::numeric_limits<ScalarOf<V>>::infinity(), capture_stretch = 1;  ///< Job::capture_within, …_stretch
    ScalarOf<V> solver_tolerance{};  ///< relative; 0: to rounding
    ScalarOf<V> tolerance{};         ///< local error of adaptive methods, relative to 1 + |value|

    // Set by the stepper, beside the arrival.
    MaskOf<V> energy_holds;    ///< the step has not lost H
    MaskOf<V> solved;          ///< the implicit equations were solved
    MaskOf<V> accepted;        ///< adaptive methods: the local error is within the tolerance
    V suggested;               ///< adaptive methods: the length of the next step, or of this one if it is to be taken again

    // Iterations of implicit solves, accumulated: those that each ray needed, and those that the packet ran.
    V open_iterations;
    std::uint64_t issued_iterations = 0;

    /// The lanes of `from` that `lanes` selects.
    void take(const Leg& from, const MaskOf<V>& lanes) {
        const CopyLanes<V> copy{lanes};
        Waypoint<V, N>::each(this->end, from.end, copy), Waypoint<V, N>::each(start, from.start, copy);
        copy(h, from.h), copy(this->energy_error, from.energy_error), copy(this->energy, from.energy), copy(this->gradients, from.gradients);
    }
};

/// … and what the stepper remembers beside it, which `begin` makes anew.
template <class V, int N = default_carried>
struct Flow : Leg<V, N> {
    /// Derivatives at the stages of the last step (Gauss), or the last forces and velocities (composition).
    PhaseGradient<V> stage[max_stages];
};

/// A way past nothing, which a stepper may go by itself.
template <class V>
struct Passage {
    V h;                       ///< length of its steps; 0 in finished lanes
    double radius;             ///< of the escape sphere
    std::uint32_t max_steps;
    // Set by the stepper.
    MaskOf<V> arrived;         ///< flow.end lies on the sphere
    V steps;                   ///< that each ray has taken
    std::uint64_t issued_steps = 0, active_lane_steps = 0;
};

}  // namespace kagero
