/// Systems whose lanes have different parameters, for sweeps: the same rays for many values of the parameters. They
/// support only explicit Runge–Kutta methods, the default of ray lists. Other steppers would take as long to compile as
/// the systems with common parameters.
#pragma once

#include "kernels/lane_parameters/lane_numbers.h"
#include "kernels/methods/steppers.h"

namespace kagero {

// Instantiated in lane_kernels.cpp.
extern template void fill_uniforms<PacketDouble>(const Node*, const int*, int, const PacketDouble*, PacketDouble*);

/// The system of H, or of Ω (H − H0) if H declares Ω. Each lane has its own parameters, and its own limit of capture.
template <class H, class V>
class LaneSystem : public System<H, Rescalable<H>, V> {
    using Base = System<H, Rescalable<H>, V>;
    static constexpr int parameter_count = static_cast<int>(H::parameters.size());
    static_assert(parameter_count <= LaneNumbers<V>::max_parameters);

public:
    /// No implicit method uses this system, so that the functions for Newton's method are not compiled.
    static constexpr bool force_needs_p = false, velocity_needs_q = false;

    /// `numbers` is LaneNumbers::numbers.
    explicit LaneSystem(const double* numbers)
        : Base(numbers), capture_radius_(parameter_of<V>(numbers, parameter_count)),
          capture_stretch_(parameter_of<V>(numbers, parameter_count + 1)) {}
    void hessian(const State<V>&, V*) const = delete;

    /// Returns the event functions at s. Rays are captured only where |(x, y, stretch·z)| ≤ capture_radius (see Job).
    KAGERO_INLINE EventFunctions<V> event_functions(const State<V>& s) const {
        EventFunctions<V> functions = Base::event_functions(s);
        if constexpr (Base::capturing) {
            const Vec3<V> q = s.q(), stretched{q.x, q.y, capture_stretch_ * q.z};
            // An infinite capture_radius does not restrict the capture: the maximum is then the captured function.
            functions.captured = max(functions.captured, norm(stretched) - capture_radius_);
        }
        return functions;
    }

private:
    V capture_radius_, capture_stretch_;
};

namespace detail {

template <class System, class V>
constexpr SpaceKernel<V> make_lane_kernel() {
    SpaceKernel<V> kernel = kernel_for_straight_rays<System, V>();
    for (const char*& reason : kernel.refusal)
        reason = "rays with different parameters are traced together only by explicit Runge-Kutta methods";
    constexpr int kind = static_cast<int>(StepperKind::runge_kutta);
    kernel.refusal[kind] = refusal<System, RungeKutta>();
    if constexpr (!refusal<System, RungeKutta>()) add_step<System, RungeKutta>(kernel, kind);
    return kernel;
}

}  // namespace detail

template <class H>
const SpaceKernel<PacketDouble>& lane_kernel() {
    using System = LaneSystem<H, PacketDouble>;
    static constexpr SpaceKernel<PacketDouble> kernel = detail::make_lane_kernel<System, PacketDouble>();
    return kernel;
}

}  // namespace kagero
