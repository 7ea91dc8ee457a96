/// What a call works on: the job, its method, and the Hamiltonian behind `SpaceKernel`.
#pragma once

#include "kernels/abi.h"
#include "kernels/methods/methods.h"
#include "kernels/methods/space_kernel.h"
#include "kernels/intersection/clearance.h"

#include <cmath>

namespace kagero {

/// What all packets of a call share.
template <class V>
struct Task {
    const Job& job;
    const Method& method;
    bool straight;
    bool carries;            ///< RayState::carry goes from step to step
    bool resumes;            ///< a step needs nothing but its start, wherever that comes from
    bool corrects_by_kutta;  ///< correction steps are taken by Kutta's method
    const SpaceKernel<V>& kernel;
    Curve<V> (*own_curve)(const StepperState<V>&,
                          const Coefficients&);  ///< null: cubic Hermite, where no other is of higher order
    SystemStorage system;
    ClearBox<V> first_box;  ///< around the camera

    Task(const Job& j, const SpaceKernel<V>& k, bool is_straight)
        : job(j), method(methods[j.integrator]), straight(is_straight), carries(visit_kind(method.kind,
                                                                                           []<class Stepper>() {
                                                                                               return requires {
                                                                                                   Stepper::carries;
                                                                                               };
                                                                                           })),
          resumes(straight || visit_kind(method.kind,
                                         []<class Stepper>() {
                                             return requires { Stepper::resumes; };
                                         })),
          corrects_by_kutta(!straight && !method.info.angular && k.step[static_cast<int>(Kind::runge_kutta)]),
          kernel(k), own_curve(straight || stages() <= 3 ? nullptr : kernel.curve[kind()]) {
        kernel.construct(system, job.parameters);
        if (job.camera && job.geometry && job.geometry->clearance) {
            const auto* q = job.camera->position;
            first_box.move(*job.geometry->clearance, {V(ScalarOf<V>(q[0])), V(ScalarOf<V>(q[1])), V(ScalarOf<V>(q[2]))},
                           ~std::uint64_t(0));
        }
    }
    /// Whether the stepper can integrate rays to the escape sphere by itself.
    bool can_integrate_to_escape() const { return !straight && kernel.integrate_to_escape[kind()]; }
    int stages() const { return method.coefficients.gauss ? method.coefficients.gauss->stages : 0; }
    void begin(StepperState<V>& f) const {
        (straight ? kernel.begin_straight : kernel.begin[kind()])(system, f, method.coefficients);
    }
    void step(StepperState<V>& f) const {
        (straight ? kernel.step_straight : kernel.step[kind()])(system, f, method.coefficients);
    }
    /// A step over the distance by which dense output has missed an event. If the step was x of the solution's radius
    /// of convergence, the cubic misses some x⁴/16 of it (Hairer, Nørsett & Wanner 1993, §II.6), and a method of order
    /// four has an error of x²⁵/10⁶ there: less than any method here has in the whole step.
    void correction_step(StepperState<V>& f) const {
        if (corrects_by_kutta) kernel.step[static_cast<int>(Kind::runge_kutta)](system, f, {.table = &kutta4});
        else step(f);
    }
    void integrate_to_escape(StepperState<V>& f, EscapeIntegration<V>& way) const {
        kernel.integrate_to_escape[kind()](system, f, method.coefficients, way);
    }
    /// The end of a step becomes the start of the next, in these lanes, or in all.
    void begin_next(Step<V>& f, const MaskOf<V>& lanes) const { copy_end_to_start(f, CopyLanes<V>{lanes}); }
    void begin_next(Step<V>& f) const {
        copy_end_to_start(f, [](V& to, const V& from) __attribute__((always_inline)) { to = from; });
    }
    int kind() const { return static_cast<int>(method.kind); }
    /// Dense output of the step in `f`.
    Curve<V> curve(const StepperState<V>& f) const {
        return own_curve ? own_curve(f, method.coefficients) : Curve<V>::hermite(f);
    }
    Extent<V> extent(const StepperState<V>& f) const {
        return own_curve ? own_curve(f, method.coefficients).extent() : Curve<V>::hermite(f).extent();
    }

private:
    template <class Copy>
    KAGERO_INLINE void copy_end_to_start(Step<V>& f, const Copy& copy) const {
        RayState<V>& here = f.start;
        const RayState<V>& there = f.end;
        RayState<V>::each_of_motion(here, there, copy);
        copy(here.energy_terms, there.energy_terms);
        if (carries)
            for (int k = 0; k < stepper_memory; ++k) copy(here.carry[k], there.carry[k]);
        if (kernel.bounded) copy(here.domain, there.domain);
        if (kernel.capturing) copy(here.captured, there.captured);
        if (kernel.bounds_steps) copy(here.max_step_length, there.max_step_length);
        if (kernel.discontinuous) copy(here.switching, there.switching);
    }
};

}  // namespace kagero
