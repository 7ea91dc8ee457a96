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
    bool carries;  ///< from step to step, Waypoint::carry
    bool resumes;  ///< a step starts from its Leg alone, wherever that comes from
    bool creeps;   ///< a step over what dense output has missed is one of Kutta's
    const SpaceKernel<V>& kernel;
    Curve<V> (*own_curve)(const Flow<V>&, const Coefficients&);  ///< null: cubic Hermite, where no other is of higher order
    SystemStorage system;
    ClearBox<V> first_box;  ///< around the camera

    Task(const Job& j, const SpaceKernel<V>& k, bool is_straight)
        : job(j), method(methods[j.integrator]), straight(is_straight),
          carries(visit_kind(method.kind, []<class Step>() { return requires { Step::carries; }; })),
          resumes(straight || visit_kind(method.kind, []<class Step>() { return requires { Step::resumes; }; })),
          creeps(!straight && !method.info.angular && k.step[static_cast<int>(Kind::runge_kutta)]), kernel(k),
          own_curve(straight || stages() <= 3 ? nullptr : kernel.curve[kind()]) {
        kernel.construct(system, job.parameters);
        if (job.camera && job.geometry && job.geometry->clearance) {
            const auto* q = job.camera->position;
            first_box.move(*job.geometry->clearance, {V(ScalarOf<V>(q[0])), V(ScalarOf<V>(q[1])), V(ScalarOf<V>(q[2]))}, ~std::uint64_t(0));
        }
    }
    /// Straight rays that nothing stops but surfaces and the escape sphere, and of which nothing is asked but where they end.
    bool in_closed_form() const {
        return straight && !kernel.bounded && !job.path_sink && !std::isfinite(job.parameter_limit) && !(job.inner_escape_radius > 0);
    }
    /// Rays that nothing stops but the escape sphere and capture, and of whose way nothing is asked, where a stepper leads them by itself.
    bool passes() const {
        return !straight && kernel.pass[kind()] && !job.geometry && !job.path_sink && !std::isfinite(job.parameter_limit);
    }
    int stages() const { return method.coefficients.gauss ? method.coefficients.gauss->stages : 0; }
    void begin(Flow<V>& f) const {
        (straight ? kernel.begin_straight : kernel.begin[kind()])(system, f, method.coefficients);
    }
    void step(Flow<V>& f) const {
        (straight ? kernel.step_straight : kernel.step[kind()])(system, f, method.coefficients);
    }
    /// A step over what dense output has missed of the last one. If that was x of the solution's radius of convergence, the cubic misses some
    /// x⁴/16 of it (Hairer, Nørsett & Wanner 1993, §II.6), and there a method of order four errs by x²⁵/10⁶: less than any method here does in
    /// the whole step.
    void creep(Flow<V>& f) const {
        if (creeps) kernel.step[static_cast<int>(Kind::runge_kutta)](system, f, {.table = &kutta4});
        else step(f);
    }
    void pass(Flow<V>& f, Passage<V>& way) const { kernel.pass[kind()](system, f, method.coefficients, way); }
    /// The end of a step becomes the start of the next, in these lanes, or in all.
    void go_on(Leg<V>& f, const MaskOf<V>& lanes) const { go_on_by(f, CopyLanes<V>{lanes}); }
    void go_on(Leg<V>& f) const {
        go_on_by(f, [](V& to, const V& from) __attribute__((always_inline)) { to = from; });
    }
    int kind() const { return static_cast<int>(method.kind); }
    /// Dense output of the step in `f`.
    Curve<V> curve(const Flow<V>& f) const { return own_curve ? own_curve(f, method.coefficients) : Curve<V>::hermite(f); }
    Extent<V> extent(const Flow<V>& f) const {
        return own_curve ? own_curve(f, method.coefficients).extent() : Curve<V>::hermite(f).extent();
    }

private:
    template <class Copy>
    KAGERO_INLINE void go_on_by(Leg<V>& f, const Copy& go) const {
        Waypoint<V>& here = f.start;
        const Waypoint<V>& there = f.end;
        Waypoint<V>::each_of_motion(here, there, go);
        go(here.energy_terms, there.energy_terms);
        if (carries)
            for (int k = 0; k < stepper_memory; ++k) go(here.carry[k], there.carry[k]);
        if (kernel.bounded) go(here.domain, there.domain);
        if (kernel.capturing) go(here.captured, there.captured);
        if (kernel.scaled) go(here.scale, there.scale);
        if (kernel.creased) go(here.side, there.side);
    }
};

}  // namespace kagero
