/// The task of one call of a kernel: the job, its method, and the functions of its Hamiltonian.
#pragma once

#include "kernels/abi.h"
#include "kernels/methods/methods.h"
#include "kernels/methods/space_kernel.h"
#include "kernels/intersection/clearance.h"

#include <cmath>

namespace kagero {

/// Returns the black hole of the ray in a lane.
inline const Hole& hole_of(const Job& job, int lane) { return job.lane_sets ? job.lane_sets[lane]->hole : job.hole; }

/// Data that all packets of a kernel call share.
template <class V>
struct Task {
    const Job& job;
    const Method& method;
    bool straight;             ///< all rays are straight
    bool keeps_memory;         ///< RayState::stepper_memory is passed from step to step
    bool steps_without_begin;  ///< `begin` is needed only at the start of a ray (methods.h)
    bool corrects_by_kutta;    ///< correction steps use the classical Runge–Kutta method of Kutta
    bool regular_in_both_charts;  ///< see methods.h
    const SpaceKernel<V>& kernel;
    /// Returns the dense output of the method; nullptr if dense output is the cubic Hermite curve.
    Curve<V> (*method_curve)(const StepperState<V>&, const Coefficients&);
    SystemStorage system;
    V escape_radius, inner_escape_radius;  ///< see Job
    ClearBox<V> camera_clear_box;  ///< clear box around the camera

    Task(const Job& j, const SpaceKernel<V>& k, bool is_straight)
        : job(j), method(methods[j.integrator]), straight(is_straight),
          keeps_memory(visit_kind(method.kind, []<class Stepper>() { return requires { Stepper::keeps_memory; }; })),
          steps_without_begin(straight || visit_kind(method.kind, []<class Stepper>() {
              return requires { Stepper::steps_without_begin; };
          })),
          corrects_by_kutta(!straight && !method.info.angular && k.step[static_cast<int>(StepperKind::runge_kutta)]),
          regular_in_both_charts(visit_kind(
              method.kind, []<class Stepper>() { return requires { Stepper::regular_in_both_charts; }; })),
          kernel(k), method_curve(straight || stages() <= 3 ? nullptr : kernel.curve[kind()]),
          escape_radius(limit_of(&Job::escape_radius, &ParameterSet::escape_radius)),
          inner_escape_radius(limit_of(&Job::inner_escape_radius, &ParameterSet::inner_escape_radius)) {
        kernel.construct(system, job.parameters);
        if (job.camera && job.geometry && job.geometry->clearance) {
            const auto* q = job.camera->start.position;
            camera_clear_box.update(*job.geometry->clearance,
                                    {V(ScalarOf<V>(q[0])), V(ScalarOf<V>(q[1])), V(ScalarOf<V>(q[2]))},
                                    ~std::uint64_t(0));
        }
    }
    /// Returns true if `integrate_to_escape` can be called.
    bool can_integrate_to_escape() const { return !straight && kernel.integrate_to_escape[kind()]; }
    /// Returns the number of stages of a Gauss method; 0 for other methods.
    int stages() const { return method.coefficients.gauss ? method.coefficients.gauss->stages : 0; }
    /// Initialises the stepper at the start of rays.
    void begin(StepperState<V>& step) const {
        (straight ? kernel.begin_straight : kernel.begin[kind()])(system, step, method.coefficients);
    }
    /// Performs one step.
    void step(StepperState<V>& step) const {
        (straight ? kernel.step_straight : kernel.step[kind()])(system, step, method.coefficients);
    }
    /// Performs a correction step, whose length is the error of the dense output at an event. A method of order four is
    /// accurate enough for the following reason. Suppose that a step covers the fraction x of the radius of convergence
    /// of the solution. The cubic Hermite curve then has an error of about x⁴/16 of the step (Hairer, Nørsett & Wanner
    /// 1993, §II.6). A correction step of this length has an error of about x²⁵/10⁶ of that radius, which is less than
    /// the error of any method in `methods` over the whole step.
    void correction_step(StepperState<V>& step) const {
        if (corrects_by_kutta)
            kernel.step[static_cast<int>(StepperKind::runge_kutta)](system, step, {.table = &kutta4});
        else this->step(step);
    }
    /// Integrates rays to the escape sphere without event detection.
    void integrate_to_escape(StepperState<V>& step, EscapeIntegration<V>& integration) const {
        kernel.integrate_to_escape[kind()](system, step, method.coefficients, integration);
    }
    /// Copies the end of a step to the start of the next step, in the given lanes or in all lanes.
    void begin_next(Step<V>& step, const MaskOf<V>& lanes) const { copy_end_to_start(step, CopyLanes<V>{lanes}); }
    void begin_next(Step<V>& step) const {
        copy_end_to_start(step, [](V& to, const V& from) __attribute__((always_inline)) { to = from; });
    }
    /// Returns the index of the stepper in the arrays of SpaceKernel.
    int kind() const { return static_cast<int>(method.kind); }
    /// Returns the dense output of a step.
    Curve<V> curve(const StepperState<V>& step) const {
        return method_curve ? method_curve(step, method.coefficients) : Curve<V>::hermite(step);
    }
    /// Returns a box that contains the dense output of a step.
    Extent<V> extent(const StepperState<V>& step) const {
        return method_curve ? method_curve(step, method.coefficients).extent() : Curve<V>::hermite(step).extent();
    }

private:
    /// Returns a member of the job, or of the parameter sets of the lanes.
    V limit_of(double Job::*shared, double ParameterSet::*own) const {
        if (!job.lane_sets) return V(ScalarOf<V>(job.*shared));
        alignas(64) double numbers[lane_count<V>];
        for (int i = 0; i < lane_count<V>; ++i) numbers[i] = job.lane_sets[i]->*own;
        return lanes_of<V>(numbers);
    }
    template <class Copy>
    KAGERO_INLINE void copy_end_to_start(Step<V>& step, const Copy& copy) const {
        RayState<V>& to = step.start;
        const RayState<V>& from = step.end;
        RayState<V>::for_each_motion_number(to, from, copy);
        copy(to.squared_energy_terms, from.squared_energy_terms);
        if (keeps_memory)
            for (int k = 0; k < stepper_memory_size; ++k) copy(to.stepper_memory[k], from.stepper_memory[k]);
        if (kernel.bounded) copy(to.domain, from.domain);
        if (kernel.capturing) copy(to.captured, from.captured);
        if (kernel.bounds_steps) copy(to.max_step_length, from.max_step_length);
        if (kernel.discontinuous || kernel.kinked) copy(to.switching, from.switching);
    }
};

}  // namespace kagero
