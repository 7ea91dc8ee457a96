/// A system whose functions are called through pointers. Newton solvers and steppers for long programs use called
/// systems, so that they are compiled once per value type (integrators/shared.h), not once per Hamiltonian. The cost of
/// the calls is small: Newton solvers run rarely, and a long program takes much longer than a call.
#pragma once

#include "kernels/equations/system.h"

namespace kagero {

/// A function of a called system: computes `out` at the state s; `system` points to the system.
template <class V>
using Call = void (*)(const void* system, const State<V>& s, V* out);

/// The functions of a system for one value type; a pointer is null if no stepper uses the function. Newton's method for
/// the implicit half steps of Satoh (2003), eq. (9), uses the first three functions. Steppers use all functions except
/// `mixed`.
template <class V>
struct Calls {
    Call<V> force, velocity;        ///< ∂K/∂q and ∂K/∂p (3 numbers each).
    Call<V> mixed;                  ///< ∂²K/∂q_i∂p_j (9 numbers, row by row).
    Call<V> derivatives;            ///< ∂K/∂(q, p), a `PhaseGradient`.
    Call<V> time_rescaling_factor;  ///< dλ/dτ (1 number).
    Call<V> carried_rates;          ///< d/dτ of the carried quantities other than λ.
};
/// The functions of a system for a single ray.
template <class S>
struct RayCalls {
    Call<S> derivatives;  ///< ∂K/∂(q, p), a `PhaseGradient`.
    Call<S> hessian;      ///< ∂²K/∂(q, p)², a `Hessian`.
};

/// Returns true if steppers use the system as a called system: if its programs are long, or if its use of time
/// rescaling differs from the default of its Hamiltonian. A system without the member `called` is not called.
template <class System>
constexpr bool is_called() {
    if constexpr (requires { System::called; }) return System::called;
    else return false;
}

/// A system that is called through pointers, with N carried quantities.
template <class V, int N = default_carried>
class CalledSystem {
    using S = ScalarOf<V>;

public:
    /// Assumed, because the programs behind the pointers are unknown at compile time.
    static constexpr bool force_needs_p = true, velocity_needs_q = true;
    static constexpr int carried = N;
    bool rescaled;  ///< True if K = Ω·(H − H0), false if K = H − H0.

    CalledSystem(const void* system, const Calls<V>& calls, const RayCalls<S>& ray, bool is_rescaled)
        : rescaled(is_rescaled), system_(system), calls_(calls), ray_(ray) {}

    KAGERO_INLINE Vec3<V> gradient_q(const State<V>& s) const { return call_vector(calls_.force, s); }
    KAGERO_INLINE Vec3<V> gradient_p(const State<V>& s) const { return call_vector(calls_.velocity, s); }
    KAGERO_INLINE void mixed(const State<V>& s, V* out) const { calls_.mixed(system_, s, out); }
    KAGERO_INLINE void derivatives(const State<V>& s, V* out) const { calls_.derivatives(system_, s, out); }
    KAGERO_INLINE V time_rescaling_factor(const State<V>& s) const {
        V out;
        calls_.time_rescaling_factor(system_, s, &out);
        return out;
    }
    KAGERO_INLINE void carried_rates(const State<V>& s, V* rates) const { calls_.carried_rates(system_, s, rates); }
    void ray_derivatives(const State<S>& s, S* out) const { ray_.derivatives(system_, s, out); }
    void ray_hessian(const State<S>& s, S* out) const { ray_.hessian(system_, s, out); }

private:
    KAGERO_INLINE Vec3<V> call_vector(Call<V> call, const State<V>& s) const {
        V out[space_size];
        call(system_, s, out);
        return {out[0], out[1], out[2]};
    }

    const void* system_;
    const Calls<V>& calls_;
    const RayCalls<S>& ray_;
};

namespace detail {

template <class System, class V>
void call_force(const void* system, const State<V>& s, V* out) {
    const Vec3<V> force = static_cast<const System*>(system)->gradient_q(s);
    out[0] = force.x;
    out[1] = force.y;
    out[2] = force.z;
}
template <class System, class V>
void call_velocity(const void* system, const State<V>& s, V* out) {
    const Vec3<V> velocity = static_cast<const System*>(system)->gradient_p(s);
    out[0] = velocity.x;
    out[1] = velocity.y;
    out[2] = velocity.z;
}
template <class System, class V>
void call_mixed(const void* system, const State<V>& s, V* out) { static_cast<const System*>(system)->mixed(s, out); }
template <class System, class V>
void call_derivatives(const void* system, const State<V>& s, V* out) {
    static_cast<const System*>(system)->derivatives(s, out);
}
template <class System, class V>
void call_time_rescaling_factor(const void* system, const State<V>& s, V* out) {
    *out = static_cast<const System*>(system)->time_rescaling_factor(s);
}
template <class System, class V>
void call_carried_rates(const void* system, const State<V>& s, V* out) {
    static_cast<const System*>(system)->carried_rates(s, out);
}
template <class System, class S>
void call_hessian(const void* system, const State<S>& s, S* out) {
    static_cast<const System*>(system)->hessian(s, out);
}

template <class System, class V>
inline constexpr Calls<V> calls_of = [] {
    Calls<V> calls{};
    if constexpr (System::force_needs_p || System::velocity_needs_q) {
        calls.force = call_force<System, V>;
        calls.velocity = call_velocity<System, V>;
        calls.mixed = call_mixed<System, V>;
    }
    if constexpr (is_called<System>()) {
        calls.derivatives = call_derivatives<System, V>;
        calls.time_rescaling_factor = call_time_rescaling_factor<System, V>;
    }
    if constexpr (carried_in<System>() > 1) calls.carried_rates = call_carried_rates<System, V>;
    return calls;
}();
template <class System, class S>
inline constexpr RayCalls<S> ray_calls_of = [] {
    if constexpr (requires(const System& system, const State<S>& s, S* out) { system.hessian(s, out); })
        return RayCalls<S>{call_derivatives<System, S>, call_hessian<System, S>};
    else return RayCalls<S>{};
}();

}  // namespace detail

/// Returns a called system that refers to `system`, which must outlive it.
template <class V, class System>
CalledSystem<V, carried_in<System>()> as_called(const System& system) {
    bool rescaled = false;
    if constexpr (requires { system.rescaled; }) rescaled = system.rescaled;
    return {&system, detail::calls_of<System, V>, detail::ray_calls_of<System, ScalarOf<V>>, rescaled};
}
/// Returns a system that is already a called system.
template <class V, int N>
const CalledSystem<V, N>& as_called(const CalledSystem<V, N>& system) { return system; }

}  // namespace kagero
