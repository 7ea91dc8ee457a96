/// Steps of one method in one space, taken through `SpaceKernel` as the tracing loop takes them.
#pragma once

#include "spaces.h"

#include "kernels/stepping/space_kernel.h"

extern "C" const kagero::Module* kagero_kernels();

namespace kagero::test {

/// The methods that serve H, as the module says.
template <class H>
const std::vector<Method>& methods_for() {
    static const std::vector<Method> served = [] {
        const Module& module = *kagero_kernels();
        std::uint32_t h = 0;
        while (std::string(module.hamiltonians[h].name) != H::name) ++h;
        std::vector<Method> all;
        for (std::uint32_t i = 0; i < module.integrator_count; ++i)
            if (!module.refusal(h, i)) all.push_back(methods[i]);
        return all;
    }();
    return served;
}

template <class V>
class Steps {
public:
    Flow<V> flow;

    template <class H>
    static Steps in(const Method& method, bool rescaled) {
        return Steps(method, space_kernel<H, V>(rescaled), default_parameters<H>().data());
    }

    /// Sets out with step length h, in every lane that of `start`.
    void begin(const State<V>& start, const V& h) {
        flow.start = flow.end = start;
        flow.h = h;
        flow.start_parameter = flow.end_parameter = flow.gradients = V(ScalarOf<V>(0));
        flow.want_parameter = flow.want_energy = true;
        kernel_.begin[static_cast<int>(method_.kind)](system_, flow);
        flow.end_velocity = flow.start_velocity;
    }
    /// One step, from flow.start to flow.end.
    void step() { kernel_.step[static_cast<int>(method_.kind)](system_, flow, method_.fractions); }
    /// n steps; flow.end is where they lead.
    void advance(int n) {
        for (int i = 0; i < n; ++i) {
            step();
            flow.start = flow.end, flow.start_velocity = flow.end_velocity, flow.start_parameter = flow.end_parameter;
        }
    }

private:
    Steps(const Method& method, const SpaceKernel<V>& kernel, const double* parameters) : method_(method), kernel_(kernel) {
        kernel_.construct(system_, parameters);
    }

    Method method_;
    SpaceKernel<V> kernel_;
    SystemStorage system_;
};

}  // namespace kagero::test
