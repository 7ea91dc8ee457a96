/// The rays of one packet and the step they are taking, in memory between the tracing loop and a stepper.
#pragma once

#include "kernels/stepping/coefficients.h"
#include "kernels/stepping/system.h"

namespace kagero {

/// What a ray takes along from a step.
template <class V>
struct Arrival {
    State<V> end;
    Vec3<V> end_velocity;
    V end_parameter;
    V energy_error;  ///< |H − H0| / (|p·∂H/∂p| + |H0|) at the end
    V energy;        ///< H at the end
    V gradients;     ///< derivative evaluations of each ray, accumulated
};

/// A step, from where it begins to where it ends.
template <class V>
struct Leg : Arrival<V> {
    // Set by the tracing loop.
    State<V> start;            ///< where the step begins
    Vec3<V> start_velocity;    ///< dq/dτ there
    V h;                       ///< step length in the integration parameter τ; 0 in finished lanes, which makes a step the identity
    V start_parameter;         ///< λ of H
    V start_domain;            ///< `domain` at the start
    V start_captured;          ///< `captured` at the start
    V start_side;              ///< `side` at the start
    V start_scale;             ///< `scale` at the start
    V start_energy_terms;      ///< `energy_terms` at the start
    bool want_parameter = false;
    bool want_energy = false;  ///< `energy_error` is wanted
    bool want_path = false;    ///< `energy` is wanted
    bool test_energy = false;  ///< `energy_holds` is wanted
    bool use_symmetry = true;  ///< Job::use_symmetry
    ScalarOf<V> solver_tolerance{};  ///< relative; 0: to rounding
    ScalarOf<V> tolerance{};         ///< local error of adaptive methods, relative to 1 + |value|

    // Set by the stepper, beside the arrival.
    V energy_terms;            ///< Survey::terms at the end
    MaskOf<V> energy_holds;    ///< the step has not lost H
    V domain;                  ///< ≤ 0 where the ray has left the medium at the end
    V side;                    ///< changes sign where H is not smooth
    V scale;                   ///< no step from the end may be longer
    V captured;                ///< ≤ 0 where the ray is captured at the end
    MaskOf<V> solved;          ///< the implicit equations were solved
    MaskOf<V> accepted;        ///< adaptive methods: the local error is within the tolerance
    V suggested;               ///< adaptive methods: the length of the next step, or of this one if it is to be taken again

    // Carried from step to step by the stepper.
    V carry[6] = {0, 0, 0, 0, 0, 0};       ///< at the start: what rounding has cut off the state (Gauss), or L (Orbit)
    V next_carry[6] = {0, 0, 0, 0, 0, 0};  ///< … and at the end

    // Iterations of implicit solves, accumulated: those that each ray needed, and those that the packet ran.
    V open_iterations;
    std::uint64_t issued_iterations = 0;
};

/// … and what the stepper remembers beside it, which `begin` makes anew.
template <class V>
struct Flow : Leg<V> {
    V stage[max_stages][6];  ///< derivatives at the stages of the last step (Gauss), or the last forces (composition)
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

/// The lanes of `from` that `lanes` selects, to `to`.
template <class V>
void copy_lanes(Arrival<V>& to, const Arrival<V>& from, const MaskOf<V>& lanes) {
    for (int k = 0; k < 7; ++k) to.end.y[k] = pick(lanes, from.end.y[k], to.end.y[k]);
    to.end_velocity = pick<V>(lanes, from.end_velocity, to.end_velocity);
    to.end_parameter = pick(lanes, from.end_parameter, to.end_parameter);
    to.energy_error = pick(lanes, from.energy_error, to.energy_error);
    to.energy = pick(lanes, from.energy, to.energy);
    to.gradients = pick(lanes, from.gradients, to.gradients);
}
template <class V>
void copy_lanes(Leg<V>& to, const Leg<V>& from, const MaskOf<V>& lanes) {
    copy_lanes(static_cast<Arrival<V>&>(to), static_cast<const Arrival<V>&>(from), lanes);
    const auto copy = [&](V& a, const V& b) __attribute__((always_inline)) { a = pick(lanes, b, a); };
    for (int k = 0; k < 7; ++k) copy(to.start.y[k], from.start.y[k]);
    for (int k = 0; k < 6; ++k) copy(to.carry[k], from.carry[k]), copy(to.next_carry[k], from.next_carry[k]);
    to.start_velocity = pick<V>(lanes, from.start_velocity, to.start_velocity);
    copy(to.h, from.h), copy(to.start_parameter, from.start_parameter);
    copy(to.start_domain, from.start_domain), copy(to.start_captured, from.start_captured);
    copy(to.start_side, from.start_side), copy(to.start_scale, from.start_scale);
    copy(to.start_energy_terms, from.start_energy_terms), copy(to.energy_terms, from.energy_terms);
    copy(to.domain, from.domain), copy(to.side, from.side), copy(to.scale, from.scale), copy(to.captured, from.captured);
}

}  // namespace kagero
