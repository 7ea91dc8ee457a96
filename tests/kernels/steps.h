/// Steps of one method in one space, taken through `SpaceKernel` as the tracing loop takes them.
#pragma once

#include "spaces.h"

#include "kernels/stepping/space_kernel.h"

#include <stdexcept>

extern "C" const kagero::Module* kagero_kernels();

namespace kagero::test {

/// The methods that serve H or Ω·(H − H0), as the module says.
template <class H>
const std::vector<Method>& methods_for(bool rescaled) {
    static const auto served = [](bool transformed) {
        const Module& module = *kagero_kernels();
        std::uint32_t h = 0;
        while (std::string(module.hamiltonians[h].name) != H::name) ++h;
        std::vector<Method> all;
        for (std::uint32_t i = 0; i < module.integrator_count; ++i)
            if (!module.refusal(h, i, transformed)) all.push_back(methods[i]);
        return all;
    };
    static const std::vector<Method> in[] = {served(false), served(true)};
    return in[rescaled];
}

/// Calls check(method, rescaled) for all forms of H and all methods that serve them.
template <class H, class Check>
void for_all_methods(const Check& check) {
    for (const bool rescaled : rescalings<H>()) {
        for (const Method& method : methods_for<H>(rescaled)) {
            SCOPED_TRACE(std::string(method.info.name) + (rescaled ? ", rescaled" : ""));
            check(method, rescaled);
        }
    }
}

inline const Method& method_named(const std::string& name) {
    for (const Method& m : methods)
        if (m.info.name == name) return m;
    throw std::runtime_error("no method " + name);
}

/// Substeps of a method, each with its roundings.
inline int stages_of(const Method& m) {
    const Coefficients& c = m.coefficients;
    return c.table ? c.table->stages : c.gauss ? c.gauss->stages : static_cast<int>(c.fractions.size()) * (m.kind == Kind::recipe ? 3 : 1);
}
inline bool collocates(const Method& m) { return m.coefficients.gauss != nullptr; }

/// The printed recipe takes each part of H by eq. (9). Where the parts are ½|p|² and V(q) that is exact, and the recipe what its name
/// says: symmetric, of the order of its fractions.
template <class H>
bool recipe_is_exact_split(const Method& m) { return m.kind == Kind::recipe && System<H, false, double>::separable; }
template <class H>
int order_on(const Method& m) {
    if (recipe_is_exact_split<H>(m)) return m.coefficients.fractions.size() == 1 ? 2 : 4;
    return static_cast<int>(m.info.order);
}
template <class H>
bool symmetric_on(const Method& m) { return m.info.symmetric || recipe_is_exact_split<H>(m); }

template <class V>
class Steps {
public:
    Flow<V> flow;

    template <class H>
    static Steps in(const Method& method, bool rescaled) {
        return with(method, space_kernel<H, V>(rescaled), default_parameters<H>().data());
    }

    static Steps with(const Method& method, const SpaceKernel<V>& kernel, const double* parameters) {
        return Steps(method, kernel, parameters);
    }

    /// Sets out with step length h, in every lane that of `start`.
    void begin(const State<V>& start, const V& h) {
        flow.start = flow.end = start;
        flow.h = h;
        flow.start_parameter = flow.end_parameter = flow.gradients = V(ScalarOf<V>(0));
        flow.want_parameter = flow.want_energy = true;
        kernel_.begin[static_cast<int>(method_.kind)](system_, flow, method_.coefficients);
        flow.end_velocity = flow.start_velocity;
    }
    /// One step, from flow.start to flow.end.
    void step() { kernel_.step[static_cast<int>(method_.kind)](system_, flow, method_.coefficients); }
    /// n steps; flow.end is where they lead.
    void advance(int n) {
        for (int i = 0; i < n; ++i) {
            step();
            flow.start = flow.end, flow.start_velocity = flow.end_velocity, flow.start_parameter = flow.end_parameter;
        }
    }

    /// With this tolerance adaptive methods accept every step, as methods of fixed step do.
    static constexpr ScalarOf<V> any_error = ScalarOf<V>(1e30f);

private:
    Steps(const Method& method, const SpaceKernel<V>& kernel, const double* parameters) : method_(method), kernel_(kernel) {
        kernel_.construct(system_, parameters);
        flow.tolerance = any_error;
    }

    Method method_;
    SpaceKernel<V> kernel_;
    SystemStorage system_;
};

}  // namespace kagero::test
